// A smooth line on a surface with the surface's normal along it: a cubic spline through knots,
// continuous to the second derivative.
//
// Coordinate u: chord length through the knots' points, so |dp/du| is 1 but for a small part. At
// either end the second derivative is that of the next knot, as on a circle, and zero on a line.
// The normal is the spline of the knots' normals, made unit.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/surface_height.h"

namespace impedraw {

struct SplinePoint {
  Eigen::Vector3d p, dp, ddp;  // point [m], and by u [1], [1/m]
  Eigen::Vector3d n, dn, ddn;  // unit normal, and by u [1/m], [1/m²]
  double along = 0;            // place on the stroke (PathSpline's second argument) [m]
};

class PathSpline {
 public:
  PathSpline() = default;
  // At least two knots; points differ. `along`: of each knot its place on the stroke
  // (stroke_part.h), interpolated between them; u if empty.
  explicit PathSpline(const std::vector<SurfaceSample>& knots,
                      const std::vector<double>& along = {});

  double length() const { return knots_.back().u; }  // of u [m]
  std::size_t spans() const { return knots_.size() - 1; }
  double start(std::size_t span) const { return knots_[span].u; }
  double end(std::size_t span) const { return knots_[span + 1].u; }
  Eigen::Vector3d point(std::size_t span, double u) const noexcept;
  SplinePoint at(double u) const noexcept;  // held at its ends outside of [0, length]

  double arc_length() const;  // [m]
  // Over one span: the largest |dp/du|, |d²p/du²| and |dp/du · d²p/du²|. The first and last are
  // sampled, the second exact.
  struct Bounds {
    double slope, bend, stretch;
  };
  Bounds bounds(std::size_t span) const;

 private:
  struct Knot {
    double u;
    Eigen::Vector3d p, m;    // point; normal
    Eigen::Vector3d p2, m2;  // their second derivatives
    double along;
  };
  SplinePoint raw(std::size_t span, double u) const noexcept;

  std::vector<Knot> knots_;
};

}  // namespace impedraw

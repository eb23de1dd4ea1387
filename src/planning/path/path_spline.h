// A smooth line on a surface, and the surface normal along it: a C² cubic spline through knots.
//
// The coordinate u is the chord length through the knots' points, so |dp/du| ≈ 1. At either end the
// second derivative equals that of the neighbouring knot, as on a circle; on a line it is zero. The
// normal is the spline of the knots' normals, normalised.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/surface_height.h"

namespace impedraw {

struct SplinePoint {
  Eigen::Vector3d p, dp, ddp;  // point [m], its derivatives by u [1], [1/m]
  Eigen::Vector3d n, dn, ddn;  // unit normal, its derivatives by u [1/m], [1/m²]
  double dalong = 0;           // derivative of `along` by u [1]
  double along = 0;            // position on the stroke (PathSpline's second argument) [m]
};

class PathSpline {
 public:
  PathSpline() = default;
  // Needs at least two knots with distinct points. `along`: each knot's position on the stroke
  // (stroke_part.h), interpolated between knots; u if empty.
  explicit PathSpline(const std::vector<SurfaceSample>& knots,
                      const std::vector<double>& along = {});

  double length() const { return knots_.back().u; }  // of u [m]
  std::size_t spans() const { return knots_.size() - 1; }
  double start(std::size_t span) const { return knots_[span].u; }
  double end(std::size_t span) const { return knots_[span + 1].u; }
  Eigen::Vector3d point(std::size_t span, double u) const noexcept;
  SplinePoint at(double u) const noexcept;  // u is clamped to [0, length]

  double arc_length() const;  // [m]
  // Over one span: the largest |dp/du|, |d²p/du²|, |dp/du · d²p/du²|, |n · d²p/du²|, |dn/du| and
  // |d²n/du²| across n. All are sampled but |d²p/du²|, which is exact.
  struct Bounds {
    double slope, bend, stretch, rise, turn, turn_bend;
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
  static void normalise(SplinePoint* s) noexcept;

  std::vector<Knot> knots_;
};

}  // namespace impedraw

// Curves to polylines whose chords stay within a stated distance of the curve.
//
// The distance of a curve P(s), 0 ≤ s ≤ 1, to its chord is at most max|P''| / 8. For a Bézier curve
// P'' is itself a Bézier curve, so its largest control point bounds it: the subdivision is adaptive
// and the tolerance a guarantee, not an estimate. A curve is also cut where it turns by more than
// `turn` a piece, so that small curves stay smooth lines and are not taken for polygons.
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

struct FlattenSettings {
  double tolerance = 0.01;  // largest distance of chord and curve; unit of the points
  double turn = 0.15;       // largest turn within one piece [rad]
};

// Each appends the points after the curve's first one to `line`, the last exactly.
void flatten_quadratic(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                       const FlattenSettings& settings, std::vector<Eigen::Vector2d>& line);
void flatten_cubic(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                   const Eigen::Vector2d& d, const FlattenSettings& settings,
                   std::vector<Eigen::Vector2d>& line);

// Part of an ellipse: centre + u cos φ + v sin φ for φ from 0 to `angle` > 0; u and v are conjugate
// half diameters.
struct EllipseArc {
  Eigen::Vector2d centre, u, v;
  double angle = 0;

  Eigen::Vector2d at(double phi) const { return centre + std::cos(phi) * u + std::sin(phi) * v; }
};
void flatten_arc(const EllipseArc& arc, const FlattenSettings& settings,
                 std::vector<Eigen::Vector2d>& line);

// The arc of at most a quarter turn whose customary approximation (handles of 4/3 tan(φ/4)) the
// cubic is; its angle is 0 if the cubic is none.
EllipseArc arc_of_cubic(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                        const Eigen::Vector2d& c, const Eigen::Vector2d& d);

}  // namespace impedraw

// Flattens curves to polylines whose chords stay within a given distance of the curve.
//
// The distance of a curve P(s), 0 ≤ s ≤ 1, to its chord is at most max|P''| / 8. For a Bézier curve
// P'' is itself a Bézier curve, bounded by its largest control point. The adaptive subdivision thus
// guarantees the tolerance. A curve is also cut where a piece would turn by more than `turn`, so
// that small curves stay smooth and are not mistaken for polygons.
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

struct FlattenSettings {
  double tolerance = 0.01;  // largest distance between chord and curve [unit of the points]
  double turn = 0.15;       // largest turn within one piece [rad]
};

// Each appends the curve's points to `line`, without the first; the last point is exact.
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

// The arc of at most a quarter turn that the cubic approximates in the customary way (handles of
// 4/3 tan(φ/4)). The angle is 0 if the cubic approximates no arc.
EllipseArc arc_of_cubic(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                        const Eigen::Vector2d& c, const Eigen::Vector2d& d);

}  // namespace impedraw

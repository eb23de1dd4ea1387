// Heading of a tool that is led along the strokes, as a blade is: its x axis lies along the
// stroke's tangent t, turned by `yaw` about the normal n.
//
//   t      = (p' − n (n·p')) / |…|                       along the spline
//   dψ/du  = b·p'' − (b·n') (n·p') over |p' − n (n·p')|,  b = n × t: turn about n per length
//   p_E    = p + trail x_E                               E leads what follows the stroke
//
// Between strokes, and at corners, it turns on the spot or in the air. Of the turns by δ + 2π k,
// the shortest is taken after which all of what follows, to the next turn, is within [least, most].
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/planning/path/path_spline.h"

namespace impedraw {

struct ToolHeading {
  double yaw = 0.0;                                         // [rad]
  double trail = 0.0;                                       // [m]
  bool lifted = false;                                      // at corners
  Eigen::Vector3d start_x_W = Eigen::Vector3d::UnitX();     // x_E at t = 0
  double least = -std::numeric_limits<double>::infinity();  // how far the arm turns it from there,
  double most = std::numeric_limits<double>::infinity();    // about n [rad]
};

struct SplineHeading {
  Eigen::Vector3d t;  // unit tangent
  double turn;        // dψ/du [rad/m]
};

inline SplineHeading heading_at(const SplinePoint& s) noexcept {
  const Eigen::Vector3d along = s.dp - s.n * s.n.dot(s.dp);
  const double length = along.norm();
  const Eigen::Vector3d t = along / length, b = s.n.cross(t);
  return {t, (b.dot(s.ddp) - b.dot(s.dn) * s.n.dot(s.dp)) / length};
}

// x turned by the angle about the unit n, to which it is perpendicular.
inline Eigen::Vector3d turned_about(const Eigen::Vector3d& n, const Eigen::Vector3d& x,
                                    double angle) noexcept {
  return std::cos(angle) * x + std::sin(angle) * n.cross(x);
}

// Turn of the tool by a spline, about its normal, and the extremes on the way [rad].
struct Turning {
  double total = 0.0, least = 0.0, most = 0.0;
};
inline Turning turning_of(const PathSpline& spline) {
  constexpr double kStep = 5e-4;  // [m]
  const int steps = std::max(8, static_cast<int>(std::ceil(spline.length() / kStep)));
  const double du = spline.length() / steps;
  Turning turn;
  for (int i = 0; i < steps; ++i) {
    turn.total += du * heading_at(spline.at((i + 0.5) * du)).turn;
    turn.least = std::min(turn.least, turn.total);
    turn.most = std::max(turn.most, turn.total);
  }
  return turn;
}

}  // namespace impedraw

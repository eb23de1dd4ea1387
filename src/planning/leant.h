// The pen's axis where it leans off the surface's normal, towards the axis of the drawing plane.
//
// An axis θ away from z turns to it by min(lean, θ/2), so that it does not jump where the surface
// is level: a wrist need not turn so far round a body, nor so low beside it.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// `n_P`: unit, in the drawing frame. n_P itself where lean_deg is 0.
inline Eigen::Vector3d leant(const Eigen::Vector3d& n_P, double lean_deg) {
  if (!(lean_deg > 0.0)) return n_P;
  const Eigen::Vector3d about = n_P.cross(Eigen::Vector3d::UnitZ());
  const double sine = about.norm();
  if (sine < 1e-9) return n_P;
  const double angle = std::min(lean_deg * std::numbers::pi / 180.0, std::atan2(sine, n_P.z()) / 2);
  return Eigen::AngleAxisd(angle, about / sine) * n_P;
}

}  // namespace impedraw

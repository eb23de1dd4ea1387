#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// The rotation by |φ| about φ.
inline Eigen::Matrix3d rotation(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

// The least rotation that takes the direction of a to that of b; of opposite ones, half a turn
// about some axis across. Eigen's FromTwoVectors finds that axis by an SVD, which costs each unit
// that includes it two seconds to compile.
inline Eigen::Quaterniond turn_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d from = a.normalized(), to = b.normalized();
  const double c = to.dot(from);
  if (c < -1.0 + 1e-12)
    return Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, from.unitOrthogonal()));
  const double s = std::sqrt((1.0 + c) * 2.0), inverse = 1.0 / s;
  Eigen::Quaterniond turn;
  turn.vec() = from.cross(to) * inverse;
  turn.w() = 0.5 * s;
  return turn;
}

}  // namespace impedraw

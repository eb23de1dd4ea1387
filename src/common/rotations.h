// Rotations: angles between vectors, rotation vectors, roll, pitch and yaw.
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// 0 … π [rad], of any lengths above 0. Exact for small angles and near π, where acos of the cosine
// is not.
inline double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

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

// Rz(yaw) Ry(pitch) Rx(roll), from (roll, pitch, yaw) in degrees: rotations about the fixed axes x,
// then y, then z.
inline Eigen::Quaterniond rotation_from_roll_pitch_yaw(const Eigen::Vector3d& rpy_deg) {
  const Eigen::Vector3d angle = rpy_deg * std::numbers::pi / 180.0;
  return Eigen::AngleAxisd(angle.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(angle.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(angle.x(), Eigen::Vector3d::UnitX());
}

}  // namespace impedraw

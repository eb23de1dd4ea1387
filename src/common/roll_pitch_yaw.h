// Rotations given as roll, pitch and yaw.
#pragma once

#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// Rz(yaw) Ry(pitch) Rx(roll), from (roll, pitch, yaw) in degrees: rotations about the fixed axes x,
// then y, then z.
inline Eigen::Quaterniond rotation_from_roll_pitch_yaw(const Eigen::Vector3d& rpy_deg) {
  const Eigen::Vector3d angle = rpy_deg * std::numbers::pi / 180.0;
  return Eigen::AngleAxisd(angle.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(angle.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(angle.x(), Eigen::Vector3d::UnitX());
}

}  // namespace impedraw

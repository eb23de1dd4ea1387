#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// The rotation by |φ| about φ.
inline Eigen::Matrix3d rotation(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, phi / angle).toRotationMatrix();
}

}  // namespace impedraw

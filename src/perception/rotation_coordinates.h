// Rotations by their rotation vector φ, R = exp(φ) R_0, and the rate of φ.
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

inline Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

// ω = A(φ) φ̇ with exp(φ) as rotation and ω in the fixed frame.
inline Eigen::Matrix3d rate_map(const Eigen::Vector3d& phi) {
  const double t2 = phi.squaredNorm(), t = std::sqrt(t2);
  const double b = t < 1e-4 ? 0.5 - t2 / 24.0 : (1.0 - std::cos(t)) / t2;
  const double c = t < 1e-4 ? 1.0 / 6.0 - t2 / 120.0 : (t - std::sin(t)) / (t2 * t);
  const Eigen::Matrix3d S = cross_matrix(phi);
  return Eigen::Matrix3d::Identity() + b * S + c * S * S;
}

}  // namespace impedraw

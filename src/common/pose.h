// Position and orientation of a frame.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

// Only an installed library has this header. What is compiled with another -march than the library,
// by a command of one's own, would lay out Eigen's types otherwise: it does not compile.
#if __has_include("impedraw/built_alike.h")
#include "impedraw/built_alike.h"
#endif

namespace impedraw {

using Vector6 = Eigen::Matrix<double, 6, 1>;  // spatial vectors, linear part first
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// X_AB: transforms coordinates in B to coordinates in A, p_A = R p_B + p.
struct Pose {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();      // p_AB [m]
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // R_AB

  Eigen::Vector3d operator*(const Eigen::Vector3d& p_B) const { return R * p_B + p; }
  Pose operator*(const Pose& X_BC) const { return {R * X_BC.p + p, R * X_BC.R}; }
  Pose inverse() const { return {-(R.transpose() * p), R.transpose()}; }
};

}  // namespace impedraw

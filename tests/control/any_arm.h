// An arm in a random state, without a model of an arm: M, J and the rest are random numbers that
// fit together.
#pragma once

#include <random>

#include "impedraw/control/operational_space.h"

namespace impedraw::testing_arm {

class AnyArm {
 public:
  explicit AnyArm(unsigned seed) : random_(seed) {}

  double number(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }
  Eigen::Vector3d vector(double size) {
    return {number(-size, size), number(-size, size), number(-size, size)};
  }
  Eigen::Vector3d direction() {
    Eigen::Vector3d x = vector(1.0);
    while (x.norm() < 0.1) x = vector(1.0);
    return x.normalized();
  }
  Vector6 wrench(double size) {
    Vector6 F;
    F << vector(size), vector(size);
    return F;
  }
  JointVector joints(double size, int n = 7) {
    JointVector x(n);
    for (double& x_j : x) x_j = number(-size, size);
    return x;
  }
  // M is positive definite, J far from singular; the joints move at up to `speed` [rad/s].
  ArmTerms terms(double speed = 0.5, int n = 7) {
    ArmTerms arm(n);
    arm.q = joints(1.0, n);
    arm.v = joints(speed, n);
    Eigen::MatrixXd L = Eigen::MatrixXd::Zero(n, n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < i; ++j) L(i, j) = number(-0.3, 0.3);
      L(i, i) = number(0.7, 1.5);
    }
    arm.M = L * L.transpose();
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < n; ++j) arm.J(i, j) = number(-0.3, 0.3) + (i == j ? 1.0 : 0.0);
    arm.Cv = joints(0.5, n);
    arm.g = joints(20.0, n);
    arm.Jdot_v = wrench(0.5);
    arm.X_WE.p = vector(0.5);
    arm.X_WE.R.col(2) = direction();
    arm.X_WE.R.col(0) = arm.X_WE.R.col(2).unitOrthogonal();
    arm.X_WE.R.col(1) = arm.X_WE.R.col(2).cross(arm.X_WE.R.col(0));
    arm.V_WE = arm.J * arm.v;
    return arm;
  }

 private:
  std::mt19937 random_;
};

}  // namespace impedraw::testing_arm

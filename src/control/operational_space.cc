#include "control/operational_space.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace impedraw {

bool OperationalSpace::update(const ArmTerms& arm) noexcept {
  factor_M_.compute(arm.M);
  Y_ = arm.J.transpose();
  factor_M_.matrixL().solveInPlace(Y_);
  A_.noalias() = Y_.transpose().lazyProduct(Y_);
  factor_A_.compute(A_);
  // The last pivots' reciprocals bound Λ's diagonal from below; the trace of the scaled Λ bounds its largest eigenvalue from above.
  if (factor_A_.info() != Eigen::Success) return release_lost_directions();
  Matrix6 U_inverse = Matrix6::Identity();
  factor_A_.matrixL().solveInPlace(U_inverse);
  const double per_length2 = 1.0 / (settings_.characteristic_length * settings_.characteristic_length);
  const double mass_bound = U_inverse.leftCols<3>().squaredNorm() + per_length2 * U_inverse.rightCols<3>().squaredNorm();
  if (mass_bound < settings_.max_effective_mass) return true;
  return release_lost_directions();
}

bool OperationalSpace::release_lost_directions() noexcept {
  Vector6 scale;
  scale << Eigen::Vector3d::Ones(), Eigen::Vector3d::Constant(settings_.characteristic_length);
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(scale.asDiagonal() * A_ * scale.asDiagonal());
  const double limit = 1.0 / settings_.max_effective_mass;
  bool regular = true;
  Vector6 released = eigen.eigenvalues();
  for (int i = 0; i < 6; ++i) {
    const double lambda = std::max(released[i], 1e-12);
    released[i] = lambda;
    if (lambda >= limit) continue;
    regular = false;
    const double epsilon = limit - lambda;
    released[i] = (lambda * lambda + epsilon * epsilon) / lambda;
  }
  if (regular && factor_A_.info() == Eigen::Success) return true;
  const Vector6 unscale = scale.cwiseInverse();
  A_ = unscale.asDiagonal() * eigen.eigenvectors() * released.asDiagonal() * eigen.eigenvectors().transpose() * unscale.asDiagonal();
  A_ = 0.5 * (A_ + A_.transpose()).eval();
  factor_A_.compute(A_);
  return false;
}

Vector6 OperationalSpace::project_to_tip(const JointVector& tau) const noexcept {
  JointVector x = tau;
  factor_M_.matrixL().solveInPlace(x);
  const Vector6 task = Y_.transpose().lazyProduct(x);
  return factor_A_.solve(task);
}

}  // namespace impedraw

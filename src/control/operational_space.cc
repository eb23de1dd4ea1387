#include "impedraw/control/operational_space.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace impedraw {

namespace {

// Cholesky factor of a symmetric matrix: the lower triangle of L. Plain loops: for these sizes
// Eigen's LLT takes twice the time. NaN where the matrix is not positive definite.
template <typename Square>
void factor(const Square& A, Square* L) noexcept {
  const auto n = A.rows();
  L->resize(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    double d = A(j, j);
    for (Eigen::Index k = 0; k < j; ++k) d -= (*L)(j, k) * (*L)(j, k);
    const double root = std::sqrt(d), inverse = 1.0 / root;
    (*L)(j, j) = root;
    for (Eigen::Index i = j + 1; i < n; ++i) {
      double x = A(i, j);
      for (Eigen::Index k = 0; k < j; ++k) x -= (*L)(i, k) * (*L)(j, k);
      (*L)(i, j) = x * inverse;
    }
  }
}

// L⁻ᵀ Y f for each column of f.
template <typename Speeds, typename Forces>
Speeds back_substituted(const JointRows& Y, const JointMatrix& L,
                        const JointVector& inverse_diagonal, const Forces& given) noexcept {
  const Eigen::Matrix<double, 6, Speeds::ColsAtCompileTime> f = given;
  Speeds x(Y.rows(), Speeds::ColsAtCompileTime);
  for (Eigen::Index i = x.rows(); i-- > 0;) {
    x.row(i) = Y.row(i).lazyProduct(f);
    for (Eigen::Index k = i + 1; k < x.rows(); ++k) x.row(i) -= L(k, i) * x.row(k);
    x.row(i) *= inverse_diagonal[i];
  }
  return x;
}

}  // namespace

bool OperationalSpace::update(const ArmTerms& arm) noexcept {
  factor(arm.M, &L_);
  const int n = static_cast<int>(arm.J.cols());
  Y_.resize(n, 6);
  inverse_diagonal_.resize(n);
  A_.setZero();
  for (int i = 0; i < n; ++i) {  // forward substitution by rows
    Eigen::Matrix<double, 1, 6> row = arm.J.col(i).transpose();
    for (int k = 0; k < i; ++k) row -= L_(i, k) * Y_.row(k);
    inverse_diagonal_[i] = 1.0 / L_(i, i);
    row *= inverse_diagonal_[i];
    Y_.row(i) = row;
    A_ += row.transpose() * row;
  }
  factor_inertia();
  // The trace of the scaled Λ is an upper bound of its largest eigenvalue. A failed factorisation
  // gives NaN, which fails the comparison.
  const double per_length2 =
      1.0 / (settings_.characteristic_length * settings_.characteristic_length);
  const double mass_bound =
      Lambda_.diagonal().head<3>().sum() + per_length2 * Lambda_.diagonal().tail<3>().sum();
  if (mass_bound < settings_.max_effective_mass) return true;
  return release_lost_directions();
}

void OperationalSpace::factor_inertia() noexcept {
  factor(A_, &U_);
  for (int i = 0; i < 6; ++i) {
    Vector6 row = Vector6::Unit(i);
    for (int k = 0; k < i; ++k) row -= U_(i, k) * U_inverse_.row(k).transpose();
    U_inverse_.row(i) = row.transpose() * (1.0 / U_(i, i));
  }
  Lambda_.noalias() = U_inverse_.transpose().lazyProduct(U_inverse_);
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
  if (regular && Lambda_.allFinite()) return true;
  const Vector6 unscale = scale.cwiseInverse();
  A_ = unscale.asDiagonal() * eigen.eigenvectors() * released.asDiagonal() *
       eigen.eigenvectors().transpose() * unscale.asDiagonal();
  A_ = 0.5 * (A_ + A_.transpose()).eval();
  factor_inertia();
  return false;
}

JointVector OperationalSpace::acceleration(const JointVector& tau) const noexcept {
  JointVector x = tau;
  const auto n = x.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < i; ++k) x[i] -= L_(i, k) * x[k];
    x[i] *= inverse_diagonal_[i];
  }
  for (Eigen::Index i = n; i-- > 0;) {
    for (Eigen::Index k = i + 1; k < n; ++k) x[i] -= L_(k, i) * x[k];
    x[i] *= inverse_diagonal_[i];
  }
  return x;
}

JointVector OperationalSpace::joint_speed(const Vector6& V) const noexcept {
  return back_substituted<JointVector>(Y_, L_, inverse_diagonal_, Lambda_ * V);
}

TwoJointSpeeds OperationalSpace::joint_speeds(const TwoVelocities& V) const noexcept {
  return back_substituted<TwoJointSpeeds>(Y_, L_, inverse_diagonal_, Lambda_.lazyProduct(V));
}

Vector6 OperationalSpace::tip_acceleration(const JointVector& tau) const noexcept {
  JointVector x = tau;
  Vector6 task = Vector6::Zero();
  for (int i = 0; i < x.size(); ++i) {
    for (int k = 0; k < i; ++k) x[i] -= L_(i, k) * x[k];
    x[i] *= inverse_diagonal_[i];
    task += x[i] * Y_.row(i).transpose();
  }
  return task;
}

Vector6 OperationalSpace::tip_acceleration_by(const Vector6& F) const noexcept {
  const JointVector x = Y_.lazyProduct(F);
  return Y_.transpose().lazyProduct(x);
}

Vector6 OperationalSpace::project_to_tip(const JointVector& tau) const noexcept {
  return Lambda_ * tip_acceleration(tau);
}

}  // namespace impedraw

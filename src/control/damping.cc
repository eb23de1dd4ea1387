#include "impedraw/control/damping.h"

#include <algorithm>
#include <cmath>

namespace impedraw {

namespace {

bool is_diagonal(const Matrix6& C, double tolerance) {
  for (int j = 1; j < 6; ++j)
    for (int i = 0; i < j; ++i)
      if (C(i, j) * C(i, j) > tolerance * tolerance * std::abs(C(i, i) * C(j, j))) return false;
  return true;
}

// One cyclic Jacobi sweep towards diagonal C: C ← Gᵀ C G, Z ← Z G for each pair.
void jacobi_sweep(Matrix6& C, Matrix6& Z) {
  for (int p = 0; p < 5; ++p) {
    for (int q = p + 1; q < 6; ++q) {
      const double off = C(p, q);
      if (off * off <= 1e-9 * std::abs(C(p, p) * C(q, q))) continue;  // most pairs on a warm start
      const double gap = C(q, q) - C(p, p);
      double t, c;
      if (off * off < 1e-8 * gap * gap) {  // nearly all on a warm start: c and t to t⁴ and t³
        t = off / gap;
        c = 1.0 - 0.5 * t * t;
      } else {
        const double theta = gap / (2.0 * off);
        t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
        c = 1.0 / std::sqrt(t * t + 1.0);
      }
      const double s = t * c;
      const Vector6 row_p = C.col(p), row_q = C.col(q);  // C is symmetric: rows equal columns
      Vector6 new_p = c * row_p - s * row_q, new_q = s * row_p + c * row_q;
      new_p[p] = row_p[p] - t * off;
      new_q[q] = row_q[q] + t * off;
      new_p[q] = new_q[p] = 0.0;
      C.col(p) = new_p;
      C.col(q) = new_q;
      C.row(p) = new_p.transpose();
      C.row(q) = new_q.transpose();
      const Vector6 z_p = Z.col(p), z_q = Z.col(q);
      Z.col(p) = c * z_p - s * z_q;
      Z.col(q) = s * z_p + c * z_q;
    }
  }
}

}  // namespace

void ModalDamping::design(const Matrix6& U, const Eigen::Matrix3d& K_linear,
                          const Eigen::Matrix3d& K_angular, double damping_ratio) noexcept {
  const Matrix6 T = U * Z_;
  Matrix6 KT;
  KT.topRows<3>().noalias() = K_linear.lazyProduct(T.topRows<3>());
  KT.bottomRows<3>().noalias() = K_angular.lazyProduct(T.bottomRows<3>());
  Matrix6 C = T.transpose() * KT;
  constexpr int kMaxSweeps = 12;  // a cold start needs 5 to 7, a warm one at most 1
  for (int sweep = 0; sweep < kMaxSweeps && !is_diagonal(C, 1e-4); ++sweep) jacobi_sweep(C, Z_);
  rate_ = 2.0 * damping_ratio * C.diagonal().cwiseMax(0.0).cwiseSqrt();
  largest_rate_ = rate_.maxCoeff();
}

Vector6 ModalDamping::apply(const Matrix6& U_inverse, const Vector6& V) const noexcept {
  const Vector6 modal = Z_.transpose() * (U_inverse * V);
  return U_inverse.transpose() * (Z_ * rate_.cwiseProduct(modal));
}

Vector6 ModalDamping::solve(const Matrix6& U, const Vector6& F) const noexcept {
  const Vector6 modal = Z_.transpose() * (U.transpose() * F);
  return U * (Z_ * modal.cwiseQuotient(rate_));
}

TipGain diagonal_damping(const TipGain& stiffness, const TipGain& inertia, double damping_ratio) {
  const auto pair = [&](const AxialGain& k, const AxialGain& m) {
    return AxialGain{2.0 * damping_ratio * std::sqrt(k.tangent * m.tangent),
                     2.0 * damping_ratio * std::sqrt(k.normal * m.normal)};
  };
  return {pair(stiffness.linear, inertia.linear), pair(stiffness.angular, inertia.angular)};
}

}  // namespace impedraw

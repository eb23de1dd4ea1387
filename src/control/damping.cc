#include "impedraw/control/damping.h"

#include <algorithm>
#include <cmath>

namespace impedraw {

namespace {

// A symmetric 6×6 matrix by its lower triangle: c[i][j], j ≤ i.
using Lower = double[6][6];

constexpr double kDiagonal = 1e-8;  // of all elements, squared tolerance
constexpr double kZero = 1e-9;      // of one element that need not be turned away

bool is_small(const Lower& c, int i, int j, double squared_tolerance) {
  return !(c[i][j] * c[i][j] > squared_tolerance * std::abs(c[i][i] * c[j][j]));
}

bool is_diagonal(const Lower& c) {
  for (int i = 1; i < 6; ++i)
    for (int j = 0; j < i; ++j)
      if (!is_small(c, i, j, kDiagonal)) return false;
  return true;
}

// Turns x and y: (x, y) ← (c x − s y, s x + c y).
void turn(double& x, double& y, double c, double s) {
  const double turned = c * x - s * y;
  y = s * x + c * y;
  x = turned;
}

// One step of Z towards the eigenvectors of a matrix, C = Zᵀ · Z, and towards ZᵀZ = I. Those of the
// posture before need no more: what remains is of the order of the step's square. Returns false,
// and leaves Z, where the step is too large for that.
// Source: T. Ogita and K. Aishima, "Iterative refinement for symmetric eigenvalue decomposition",
// Japan J. Indust. Appl. Math. 35, 2018.
bool refine(const Lower& C, Matrix6& Z) {
  constexpr double kNear = 1e-2;
  Matrix6 E;
  Vector6 k;
  for (int i = 0; i < 6; ++i) {
    const double lacks = 1.0 - Z.col(i).squaredNorm();
    E(i, i) = 0.5 * lacks;
    k[i] = C[i][i] / (1.0 - lacks);
  }
  double furthest = 0.0;
  for (int i = 1; i < 6; ++i) {
    for (int j = 0; j < i; ++j) {
      const double lacks = -Z.col(i).dot(Z.col(j));
      if (is_small(C, i, j, kZero)) {
        E(i, j) = E(j, i) = 0.5 * lacks;
        continue;
      }
      const double by_gap = 1.0 / (k[j] - k[i]);
      E(i, j) = (C[i][j] + k[j] * lacks) * by_gap;
      E(j, i) = -(C[i][j] + k[i] * lacks) * by_gap;
      furthest = std::max(furthest, std::abs(C[i][j] * by_gap));
    }
  }
  if (!(furthest < kNear)) return false;
  Z += (Z * E).eval();
  return true;
}

// One cyclic Jacobi sweep towards diagonal C: C ← Gᵀ C G, Z ← Z G for each pair. By elements: whole
// columns, loaded just after single elements of them were stored, take twice the time.
void jacobi_sweep(Lower& C, Matrix6& Z) {
  for (int p = 0; p < 5; ++p) {
    for (int q = p + 1; q < 6; ++q) {
      const double off = C[q][p];
      if (is_small(C, q, p, kZero)) continue;
      const double theta = (C[q][q] - C[p][p]) / (2.0 * off);
      const double t =
          std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
      const double c = 1.0 / std::sqrt(t * t + 1.0);
      const double s = t * c;
      C[p][p] -= t * off;
      C[q][q] += t * off;
      C[q][p] = 0.0;
      for (int k = 0; k < p; ++k) turn(C[p][k], C[q][k], c, s);
      for (int k = p + 1; k < q; ++k) turn(C[k][p], C[q][k], c, s);
      for (int k = q + 1; k < 6; ++k) turn(C[k][p], C[k][q], c, s);
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
  Lower C;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) C[i][j] = T.col(i).dot(KT.col(j));
  constexpr int kMaxSweeps = 12;  // a cold start needs 5 to 7
  if (!is_diagonal(C) && !refine(C, Z_)) {
    for (int sweep = 0; sweep < kMaxSweeps && !is_diagonal(C); ++sweep) jacobi_sweep(C, Z_);
  }
  for (int i = 0; i < 6; ++i) rate_[i] = 2.0 * damping_ratio * std::sqrt(std::max(C[i][i], 0.0));
  largest_rate_ = rate_.maxCoeff();
}

Vector6 ModalDamping::apply(const Matrix6& U_inverse, const Vector6& V) const noexcept {
  const Vector6 modal = Z_.transpose() * (U_inverse * V);
  return U_inverse.transpose() * (Z_ * rate_.cwiseProduct(modal));
}

Vector6 ModalDamping::solve(const Matrix6& U, const Vector6& F) const noexcept {
  const Vector6 modal = Z_.transpose() * (U.transpose() * F);
  // A mode without damping has no stiffness either, and follows nothing.
  return U * (Z_ * (rate_.array() > 0.0).select(modal.cwiseQuotient(rate_), Vector6::Zero()));
}

TipGain diagonal_damping(const TipGain& stiffness, const TipGain& inertia, double damping_ratio) {
  const auto pair = [&](const AxialGain& k, const AxialGain& m) {
    return AxialGain{2.0 * damping_ratio * std::sqrt(k.tangent * m.tangent),
                     2.0 * damping_ratio * std::sqrt(k.normal * m.normal)};
  };
  return {pair(stiffness.linear, inertia.linear), pair(stiffness.angular, inertia.angular)};
}

}  // namespace impedraw

// Damping from stiffness and inertia, mode by mode.
//
// Law      K' Q = M_d Q diag(k),  Qᵀ M_d Q = I,  B = M_d Q diag(2 ζ √k) Qᵀ M_d
//          Why not a scalar recipe: docs/decisions/0006.
// Gives    every mode of M_d ẍ + B ẋ + K' x = 0 the same damping ratio ζ
// With     M_d = A⁻¹, A = U Uᵀ, this is B = 2 ζ U⁻ᵀ C^½ U⁻¹, C = Uᵀ K' U.
//
// K' must be positive definite: axes without stiffness take a stated reference stiffness.
// A discrete loop needs max eig(M_d⁻¹ B) (Δt + delay) < 0.5; max eig = 2 ζ √k_max.
#pragma once

#include "impedraw/common/pose.h"
#include "impedraw/control/axial_gain.h"

namespace impedraw {

inline constexpr double kDampingLimit = 0.5;  // of max eig(M_d⁻¹ B) (Δt + delay)

// For a desired inertia that turns with the posture (M_d = Λ): one call a step. Jacobi rotations
// start from the last call's modes, so that a posture which moves by a step costs one sweep;
// off-diagonal terms that are left are below 1e-4 of the diagonal's scale: damping ratios hold to
// 2e-3.
class ModalDamping {
 public:
  // U: lower factor of A = M_d⁻¹. K': block-diagonal, linear and angular part.
  void design(const Matrix6& U, const Eigen::Matrix3d& K_linear, const Eigen::Matrix3d& K_angular,
              double damping_ratio) noexcept;

  // B V, for the inverse of the same factor. B itself is never formed.
  Vector6 apply(const Matrix6& U_inverse, const Vector6& V) const noexcept;
  // B⁻¹ F, for the factor of design().
  Vector6 solve(const Matrix6& U, const Vector6& F) const noexcept;
  // max eig(M_d⁻¹ B) of the last design [1/s]
  double largest_rate() const { return largest_rate_; }

 private:
  Matrix6 Z_ = Matrix6::Identity();  // eigenvectors of C
  Vector6 rate_ = Vector6::Zero();   // 2 ζ √k of each mode [1/s]
  double largest_rate_ = 0.0;
};

// For a desired inertia that is constant in S and diagonal there, the modes are the axes
// themselves: b = 2 ζ √(k m).
TipGain diagonal_damping(const TipGain& stiffness, const TipGain& inertia, double damping_ratio);

}  // namespace impedraw

// Modal damping from stiffness and inertia.
//
// Law      K' Q = M_d Q diag(k),  Qᵀ M_d Q = I,  B = M_d Q diag(2 ζ √k) Qᵀ M_d
//          docs/decisions/0006 explains why a scalar rule is not enough.
// Gives    every mode of M_d ẍ + B ẋ + K' x = 0 the same damping ratio ζ
// With     M_d = A⁻¹, A = U Uᵀ, this is B = 2 ζ U⁻ᵀ C^½ U⁻¹, C = Uᵀ K' U.
//
// K' must be positive definite: axes without stiffness use a reference stiffness.
// A discrete loop requires max eig(M_d⁻¹ B) (Δt + delay) < 0.5; max eig = 2 ζ √k_max.
#pragma once

#include "impedraw/common/pose.h"
#include "impedraw/control/axial_gain.h"

namespace impedraw {

inline constexpr double kDampingLimit = 0.5;  // of max eig(M_d⁻¹ B) (Δt + delay)

// Rate of a damping that is well within what the sampled loop bears: a third of it [1/s].
// damping_delay: TimingSettings::damping_delay() [s].
inline double bearable_rate(double damping_delay) { return kDampingLimit / 3.0 / damping_delay; }

// Damping for a desired inertia that depends on the posture (M_d = Λ): call design() once per step.
// The previous modes are refined; where the posture has changed by more than a step, Jacobi
// rotations find them. Remaining off-diagonal terms are below 1e-4 of the diagonal's scale. Damping
// ratios are accurate to 2e-3.
class ModalDamping {
 public:
  // U: lower factor of A = M_d⁻¹. K': block-diagonal, given by its linear and angular parts.
  void design(const Matrix6& U, const Eigen::Matrix3d& K_linear, const Eigen::Matrix3d& K_angular,
              double damping_ratio) noexcept;

  // B V, given the inverse of the same factor. B itself is never formed.
  Vector6 apply(const Matrix6& U_inverse, const Vector6& V) const noexcept;
  // B⁻¹ F, given the factor passed to design().
  Vector6 solve(const Matrix6& U, const Vector6& F) const noexcept;
  // max eig(M_d⁻¹ B) of the last design [1/s]
  double largest_rate() const { return largest_rate_; }

 private:
  Matrix6 Z_ = Matrix6::Identity();  // eigenvectors of C
  Vector6 rate_ = Vector6::Zero();   // 2 ζ √k of each mode [1/s]
  double largest_rate_ = 0.0;
};

// Damping for a desired inertia that is constant and diagonal in S. The modes are then the axes:
// b = 2 ζ √(k m).
TipGain diagonal_damping(const TipGain& stiffness, const TipGain& inertia, double damping_ratio);

}  // namespace impedraw

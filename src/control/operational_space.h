// The arm seen from its tip: operational-space inertia and the dynamically consistent inverse.
//
// Definition  Λ = (J M⁻¹ Jᵀ)⁻¹                                      (8)
//             J̄ᵀ = Λ J M⁻¹                                         (16)
// Identities  J̄ᵀ Jᵀ = I
//             J M⁻¹ (I − Jᵀ J̄ᵀ) τ = 0 for every τ                   (17)
//             the null space leaks no acceleration into the task
// Source      Khatib 1987 (impedance.h); consistent null space: Khatib, "Inertial properties in
//             robotic manipulation", IJRR 14(1), 1995.
//
// Computed from Cholesky factors: M = L Lᵀ, Y = L⁻¹ Jᵀ, A = Yᵀ Y = Λ⁻¹ = U Uᵀ, Λ = U⁻ᵀ U⁻¹. Both
// triangles of A and Λ exist; M⁻¹ is never formed.
//
// Near a singular posture the tip's effective mass
// grows without bound along a direction. Above `max_effective_mass` that direction is released
// smoothly: Λ⁻¹ is replaced there by (λ² + ε²)/λ, ε from 0 up, so that torque stays bounded.
// Elsewhere nothing is damped.
#pragma once

#include <Eigen/Cholesky>

#include "impedraw/control/arm_terms.h"

namespace impedraw {

struct OperationalSpaceSettings {
  double max_effective_mass = 400.0;  // [kg]; beyond it a direction counts as lost
  // [m]; makes an inertia I about an axis comparable with a mass, I / length²
  double characteristic_length = 0.3;
};

class OperationalSpace {
 public:
  explicit OperationalSpace(const OperationalSpaceSettings& settings = {}) : settings_(settings) {}

  // Refactors for this posture. Returns false near a singularity (the products below then are the
  // released ones).
  bool update(const ArmTerms& arm) noexcept;

  const Matrix6& inertia() const { return Lambda_; }            // Λ
  const Matrix6& inverse_inertia() const { return A_; }         // Λ⁻¹ = U Uᵀ
  const Matrix6& inverse_inertia_factor() const { return U_; }  // U, lower triangular
  const Matrix6& inertia_factor() const { return U_inverse_; }  // U⁻¹: Λ = U⁻ᵀ U⁻¹

  // J̄ᵀ τ: the wrench at the tip that τ amounts to
  Vector6 project_to_tip(const JointVector& tau) const noexcept;

 private:
  void factor_inertia() noexcept;
  bool release_lost_directions() noexcept;

  OperationalSpaceSettings settings_;
  Eigen::LLT<JointMatrix> factor_M_;
  // rows of fixed length: what a small solve vectorises over
  Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor, kMaxJoints, 6> Y_;
  Matrix6 A_ = Matrix6::Identity(), U_ = A_, U_inverse_ = A_, Lambda_ = A_;
};

}  // namespace impedraw

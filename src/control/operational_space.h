// Operational-space inertia and dynamically consistent inverse of the arm at its tip.
//
// Definition  Λ = (J M⁻¹ Jᵀ)⁻¹                                      (8)
//             J̄ᵀ = Λ J M⁻¹                                         (16)
// Identities  J̄ᵀ Jᵀ = I
//             J M⁻¹ (I − Jᵀ J̄ᵀ) τ = 0 for every τ                   (17)
//             null-space torque causes no task acceleration
// Source      Khatib 1987 (impedance.h); consistent null space: Khatib, "Inertial properties in
//             robotic manipulation", IJRR 14(1), 1995.
//
// Computed from Cholesky factors: M = L Lᵀ, Y = L⁻¹ Jᵀ, A = Yᵀ Y = Λ⁻¹ = U Uᵀ, Λ = U⁻ᵀ U⁻¹. Both
// triangles of A and Λ are filled; M⁻¹ is never formed.
//
// Near a singular posture the tip's effective mass grows without bound along one direction. Above
// `max_effective_mass` that direction is released smoothly: the eigenvalue λ of Λ⁻¹ becomes
// (λ² + ε²)/λ, with ε growing from 0, so that torque stays bounded. Other directions are unchanged.
#pragma once

#include <Eigen/Core>

#include "impedraw/control/arm_terms.h"

namespace impedraw {

struct OperationalSpaceSettings {
  double max_effective_mass = 400.0;  // [kg]; above it a direction counts as lost
  // [m]; converts an inertia I about an axis to a comparable mass, I / length²
  double characteristic_length = 0.3;
};

using JointRows = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor, kMaxJoints, 6>;
// Two velocities of the tip, and the joint speeds that they ask for.
using TwoVelocities = Eigen::Matrix<double, 6, 2>;
using TwoJointSpeeds = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor, kMaxJoints, 2>;

class OperationalSpace {
 public:
  explicit OperationalSpace(const OperationalSpaceSettings& settings = {}) : settings_(settings) {}

  // Factors M and Λ⁻¹ for this posture. Returns false near a singularity: the matrices below then
  // include the release.
  bool update(const ArmTerms& arm) noexcept;

  const Matrix6& inertia() const { return Lambda_; }            // Λ
  const Matrix6& inverse_inertia() const { return A_; }         // Λ⁻¹ = U Uᵀ
  const Matrix6& inverse_inertia_factor() const { return U_; }  // U, lower triangular
  const Matrix6& inertia_factor() const { return U_inverse_; }  // U⁻¹: Λ = U⁻ᵀ U⁻¹

  // M⁻¹ τ
  JointVector acceleration(const JointVector& tau) const noexcept;
  // J̄ V = M⁻¹ Jᵀ Λ V: of all joint velocities that move the tip at V, that of least energy
  JointVector joint_speed(const Vector6& V) const noexcept;
  TwoJointSpeeds joint_speeds(const TwoVelocities& V) const noexcept;
  // J M⁻¹ τ and J M⁻¹ Jᵀ F, near a singularity without the release
  Vector6 tip_acceleration(const JointVector& tau) const noexcept;
  Vector6 tip_acceleration_by(const Vector6& F) const noexcept;
  // J̄ᵀ τ: the wrench at the tip that is equivalent to τ
  Vector6 project_to_tip(const JointVector& tau) const noexcept;

 private:
  void factor_inertia() noexcept;
  bool release_lost_directions() noexcept;

  OperationalSpaceSettings settings_;
  JointMatrix L_;  // lower triangle only
  // rows of fixed length let the compiler vectorise the small solve
  JointRows Y_;
  JointVector inverse_diagonal_;  // of the factor of M
  Matrix6 A_ = Matrix6::Identity(), U_ = A_, U_inverse_ = A_, Lambda_ = A_;
};

}  // namespace impedraw

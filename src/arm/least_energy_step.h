// The joints' motion of least kinetic energy for a given motion of the tip, as under the
// controller:
//   dq = J̄ dx + (I − J̄ J) M⁻¹ W d,   J̄ = M⁻¹ Jᵀ (J M⁻¹ Jᵀ + ε I)⁻¹,   d = q_0 − q
// W is a constant diagonal matrix, as the null space's stiffness is. The redundant joints then go
// down ½ dᵀ W d; with M(q) in its place they would have no potential, and could wind up for ever.
// The turn about the pen is free only where the caller leaves it out of dx.
// Source: O. Khatib 1987, equation (16) of control/impedance.h.
#pragma once

#include <Eigen/Cholesky>

#include "impedraw/control/arm_terms.h"
#include "impedraw/control/heading.h"
#include "impedraw/control/normal_tracker.h"

namespace impedraw {

struct LeastEnergyStep {
  JointVector task;       // J̄ dx [rad]
  JointVector redundant;  // (I − J̄ J) M⁻¹ W d, which does not move the tip [rad]
};

// dx: of the tip, linear part first, in W [m, rad]. pull: W d [kg m² rad]. epsilon: keeps the step
// finite at singular postures [1/kg].
inline LeastEnergyStep least_energy_step(const ArmTerms& arm, const Vector6& dx,
                                         const JointVector& pull, double epsilon) {
  const TipJacobian& J = arm.J;
  const auto M = arm.M.llt();
  const Eigen::MatrixXd M_inv_Jt = M.solve(J.transpose());
  const JointVector drift = M.solve(pull);
  const Matrix6 A = J * M_inv_Jt + epsilon * Matrix6::Identity();
  const Eigen::LLT<Matrix6> factor = A.llt();
  return {M_inv_Jt * factor.solve(dx), drift - M_inv_Jt * factor.solve(J * drift)};
}

// W of a posture: its joints relax about as they would alone, share by share.
inline JointVector relaxation_weight(const ArmTerms& arm) { return arm.M.diagonal(); }

// The displacement that brings the tip to p_W with its z axis along z_W: by the smallest rotation,
// and, unless x_W is zero, by a turn about z that brings its x axis there.
inline Vector6 tip_displacement(const Pose& X_WE, const Eigen::Vector3d& p_W,
                                const Eigen::Vector3d& z_W,
                                const Eigen::Vector3d& x_W = Eigen::Vector3d::Zero()) {
  Vector6 dx;
  dx << p_W - X_WE.p, smallest_rotation(X_WE.R.col(2), z_W);
  if (!x_W.isZero()) dx.tail<3>() += yaw_between(X_WE.R.col(0), x_W, z_W) * z_W;
  return dx;
}

}  // namespace impedraw

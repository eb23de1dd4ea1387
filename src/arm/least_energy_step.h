// The joints' motion of least kinetic energy for a given motion of the tip, as under the
// controller:
//   dq = J̄ dx + (I − J̄ J) M⁻¹ W d,   J̄ = M⁻¹ Jᵀ (J M⁻¹ Jᵀ + ε I)⁻¹,   d = q_0 − q
// W is a constant diagonal matrix, as the null space's stiffness is. The redundant joints then go
// down ½ dᵀ W d; with M(q) in its place they would have no potential, and could wind up for ever.
// The turn about the pen is free only where the caller leaves it out of dx.
// Source: O. Khatib 1987, equation (16) of control/impedance.h.
#pragma once

#include "impedraw/control/arm_terms.h"

namespace impedraw {

struct LeastEnergyStep {
  JointVector task;       // J̄ dx [rad]
  JointVector redundant;  // (I − J̄ J) M⁻¹ W d, which does not move the tip [rad]
};

// dx: of the tip, linear part first, in W [m, rad]. pull: W d [kg m² rad]. epsilon: keeps the step
// finite at singular postures [1/kg].
LeastEnergyStep least_energy_step(const ArmTerms& arm, const Vector6& dx, const JointVector& pull,
                                  double epsilon);

// W of a posture: its joints relax about as they would alone, share by share.
inline JointVector relaxation_weight(const ArmTerms& arm) { return arm.M.diagonal(); }

// What is missing for the tip to be at p_W with its z axis along z_W: by the smallest rotation,
// and, unless x_W is zero, by a turn about z that brings its x axis there.
Vector6 tip_displacement(const Pose& X_WE, const Eigen::Vector3d& p_W, const Eigen::Vector3d& z_W,
                         const Eigen::Vector3d& x_W = Eigen::Vector3d::Zero());

}  // namespace impedraw

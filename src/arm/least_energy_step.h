// The joints' motion of least kinetic energy for a given motion of the tip, as under the
// controller:
//   dq = J̄ dx + (I − J̄ J) dq_0,   J̄ = M⁻¹ Jᵀ (J M⁻¹ Jᵀ + ε I)⁻¹
// The turn about the pen is free only where the caller leaves it out of dx.
// Source: O. Khatib 1987, equation (16) of control/impedance.h.
#pragma once

#include "impedraw/control/arm_terms.h"

namespace impedraw {

struct LeastEnergyStep {
  JointVector task;       // J̄ dx [rad]
  JointVector redundant;  // (I − J̄ J) dq_0, which does not move the tip [rad]
};

// dx: of the tip, linear part first, in W [m, rad]. drift: dq_0 [rad]. epsilon: keeps the step
// finite at singular postures [1/kg].
LeastEnergyStep least_energy_step(const ArmTerms& arm, const Vector6& dx, const JointVector& drift,
                                  double epsilon);

// What is missing for the tip to be at p_W with its z axis along z_W: by the smallest rotation.
Vector6 tip_displacement(const Pose& X_WE, const Eigen::Vector3d& p_W, const Eigen::Vector3d& z_W);

}  // namespace impedraw

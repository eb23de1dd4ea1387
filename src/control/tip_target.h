// Desired motion of the tip in one step, and the pull of the springs towards it: V_d, V̇_d and K e
// of the law (1). Two pure functions, one for the motion on the plan and one for that on the
// surface.
//
// On the plan     e is the error of the pose, with full stiffness; a retreat adds retreat_height.
// On the surface  The ink follows the plan, seen along the drawing axis z (13): ErrorProjection.
//                 Along n there is no stiffness in contact; the approach sinks along z, or along n.
//                 The pen's axis is −n_T, or the plan's (PenAxis).
// The ink         lies at C, under the centre of the tip's ball of radius r:
//                   p_C = p_E + p_EC,   p_EC = give n_C − r (z_E + n_C),   give = push / stiffness
//                 and D is where E must be for C to be on the plan: p_WD = p_plan − p_EC.
// A swelling     force sinks the tip in contact: V_d −= n Ḟ_n / stiffness
// On a carrier    the plan's motion relative to the carrier K is projected, in axes that turn with
//                 it, and K's motion is added again:
//                   V̇ += a_K + 2 ω × v_rel,   V += v_K + rise n
// Requires        unit n; |z| = 1
#pragma once

#include "impedraw/control/contact.h"

namespace impedraw {

struct TipTarget {
  Vector6 V = Vector6::Zero();                         // V_d [m/s, rad/s]
  Vector6 Vdot = Vector6::Zero();                      // V̇_d [m/s², rad/s²]
  Vector6 Ke = Vector6::Zero();                        // K e [N, Nm]
  Eigen::Vector3d p_WD = Eigen::Vector3d::Zero();      // desired tip [m]
  Eigen::Vector3d axis_WD = Eigen::Vector3d::UnitZ();  // desired pen axis, outward: z_D = −axis_WD
};

TipTarget target_on_plan(const StepInput& in, const Contact& contact,
                         const ImpedanceSettings& settings) noexcept;

// push: the force along −n that compresses the tip now [N]. The full push would command a shift
// along the surface while friction still holds the tip.
TipTarget target_on_surface(const StepInput& in, const Contact& contact, double push,
                            const ImpedanceSettings& settings) noexcept;

}  // namespace impedraw

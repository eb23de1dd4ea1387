// Inputs of one control step, and what the step reports about them.
#pragma once

#include <cmath>

#include "impedraw/control/arm_terms.h"
#include "impedraw/control/impedance_settings.h"
#include "impedraw/control/moving_frame.h"
#include "impedraw/control/surface_estimate.h"
#include "impedraw/control/tip_reference.h"

namespace impedraw {

using Wrench = Vector6;  // [force; torque] at the origin of E, in W [N, Nm]

// Age of a step's inputs beyond timing.loop_delay and timing.wrench_delay [s].
struct InputAges {
  double state = 0.0, wrench = 0.0;
};

struct ControlStatus {
  // An input is not finite or has the wrong size, M is not positive definite, or a normal is not of
  // unit length. The torque goes to the last gravity torque.
  bool bad_input = false;
  bool near_singular = false;   // a direction of the tip was released
  bool stale_state = false;     // older than timing.max_state_age; torque as for bad_input
  bool stale_wrench = false;    // older than timing.max_wrench_age; the pen leaves the surface
  bool torque_limited = false;  // a limit on torque or torque rate was active
  bool speed_limited = false;   // limits.tip_speed, turn_speed or joint_speed was active
  bool joint_limit = false;     // a joint is within joint_range.margin of its limit
  bool surface_lost = false;    // contact is desired but perception has no surface here
  bool damping_limit = false;  // M_d ∝ Λ: max eig(M_d⁻¹B)(Δt + delay) ≥ 0.5 in this posture
  bool stiff_contact = false;  // the arm's own inertia counts: stiff_contact.h
  bool ok() const {
    return !(bad_input || near_singular || stale_state || stale_wrench || torque_limited ||
             speed_limited || joint_limit || surface_lost || damping_limit || stiff_contact);
  }
};

// A step's inputs, in W.
struct StepInput {
  const ArmTerms& arm;
  const TipReference& reference;
  const SurfaceEstimate& surface;
  Wrench F_ext;                // zero where it is not measured, or stale
  bool wrench_lost;            // measured, but stale
  const FrameMotion* carrier;  // motion of the canvas; null: it stands
};

// Checks age, size and finiteness of the inputs: sets bad_input, stale_state and stale_wrench.
// joints: number for which the controller was made.
inline ControlStatus input_status(const ArmTerms& arm, const TipReference& reference,
                                  const SurfaceEstimate& surface, const Wrench& F_ext,
                                  const InputAges& ages, const ImpedanceSettings& settings,
                                  Eigen::Index joints) noexcept {
  const bool measured = settings.wrench == WrenchFeedback::measured;
  ControlStatus status;
  status.stale_state = !(ages.state <= settings.timing.max_state_age);
  status.stale_wrench = measured && !(ages.wrench <= settings.timing.max_wrench_age);
  status.bad_input = true;
  const auto unit = [](const Eigen::Vector3d& n) { return std::abs(n.squaredNorm() - 1.0) < 1e-6; };
  if (arm.q.size() != joints || arm.v.size() != joints || arm.M.rows() != joints ||
      arm.M.cols() != joints || arm.Cv.size() != joints || arm.g.size() != joints ||
      arm.J.cols() != joints || !unit(reference.n_WD))
    return status;
  double sum = arm.q.sum() + arm.v.sum() + arm.M.sum() + arm.Cv.sum() + arm.g.sum() + arm.J.sum() +
               arm.Jdot_v.sum() + arm.X_WE.p.sum() + arm.X_WE.R.sum() + arm.V_WE.sum() +
               reference.p_WD.sum() + reference.v_WD.sum() + reference.a_WD.sum() +
               reference.n_WD.sum() + reference.w_WD.sum() + reference.alpha_WD.sum() +
               reference.x_WD.sum() + reference.yaw_rate + reference.yaw_acceleration +
               reference.force_rate + (reference.force >= 0.0 ? reference.force : NAN);
  if (surface.status == SurfaceStatus::ok) {
    if (!unit(surface.n_W)) return status;
    sum += surface.n_W.sum() + surface.distance;
  }
  if (measured && !status.stale_wrench) sum += F_ext.sum();
  status.bad_input = !std::isfinite(sum);
  return status;
}

}  // namespace impedraw

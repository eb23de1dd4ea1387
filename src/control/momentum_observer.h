// Momentum observer: estimates the torque that the arm's model does not explain, such as joint
// friction, wrong masses or an unknown payload.
//
// Plant     M v̇ + C v + g = τ + Jᵀ F_ext + d,   d: unmodelled torque [Nm]
// Observer  r = K_o ∫ ( M dv − (τ + Jᵀ F_ext − C v − g + r) dt )
// so        ṙ = K_o (d − r): d through a first-order low-pass of bandwidth K_o
// Use       the law subtracts r_c + Jᵀ J̄ᵀ (r − r_c) from its torque, r_c: r within yield_limit.
//           Each r_j is bounded by `limit`, so that r cannot wind up.
//
// ∫ M dv replaces M v − ∫ Ṁ v dt, so that neither C nor Ṁ nor an acceleration is formed. It is the
// sum of M_i (v_i+1 − v_i) over the steps. The wrench must be subtracted, or the observer would
// cancel the push: without a measured wrench the observer is off. Delayed wrenches and torques are
// aligned with the motion that they belong to.
// Source: De Luca, Mattone, "Sensorless robot collision detection and hybrid force/motion control",
// ICRA 2005.
#pragma once

#include <array>
#include <vector>

#include "impedraw/control/arm_terms.h"

namespace impedraw {

struct ObserverSettings {
  bool enabled = true;       // needs a measured wrench
  double bandwidth = 200.0;  // K_o [rad/s]
  double limit = 40.0;       // of each |r_j| [Nm]
  // A bound for each joint [Nm]. The excess of r_j, and a share of the joint's weight torque on top
  // of it (impedance.h), is compensated only where it would move the tip, so that a push on the
  // arm's body moves the arm through its null space. Empty: no such bound.
  std::vector<double> yield_limit;

  void validate() const;  // throws InputError naming the setting and what is valid
};

class MomentumObserver {
 public:
  // wrench_age: age of the wrench beyond the step that has just ended [s]. torque_delay: time from
  // computing a torque until it acts [s]. Both are rounded to steps. Throws InputError for a value
  // out of range.
  MomentumObserver(const ObserverSettings& settings, int joints, double dt, double wrench_age,
                   double torque_delay);

  // Call at the start of a step, with the arm's current state and the newest F_ext [N, Nm], taken
  // at E, in W. Returns r.
  const JointVector& update(const ArmTerms& arm, const Vector6& F_ext) noexcept;
  // Call at the end of a step, with the commanded torque after all limits.
  void commanded(const JointVector& tau) noexcept;

  const JointVector& disturbance() const { return r_; }  // r [Nm]
  void pause() noexcept { step_ = 0; }  // for a step without a wrench: keeps r, restarts history
  void reset() noexcept;                // clears r and the history

 private:
  static constexpr int kHistory = 32;  // steps

  ObserverSettings settings_;
  double dt_, gain_;
  int wrench_steps_, torque_steps_;
  long step_ = 0;                                  // commands so far
  JointMatrix M_;                                  // of the last step
  JointVector v_, bias_;                           // v and C v + g of the last step
  std::array<JointVector, kHistory> unexplained_;  // M dv/dt + C v + g − τ of past steps
  std::array<JointVector, kHistory> tau_;
  JointVector r_;
};

}  // namespace impedraw

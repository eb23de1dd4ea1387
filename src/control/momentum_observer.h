// What the model of the arm misses, found from its momentum: joint friction, wrong masses, an
// unknown payload.
//
// Plant     M v̇ + C v + g = τ + Jᵀ F_ext + d,   d: what the model misses [Nm]
// Observer  r = K_o ∫ ( M dv − (τ + Jᵀ F_ext − C v − g + r) dt )
// so        ṙ = K_o (d − r): d through a first-order low-pass of bandwidth K_o
// Use       the law takes r off its torque. r is bounded joint by joint, and a bounded state of a
//           low-pass cannot wind up.
//
// ∫ M dv stands for M v − ∫ Ṁ v dt, so that neither C nor Ṁ is formed, and no acceleration: it is
// summed from the steps' own increments of v, which in a sampled loop is M_i (v_i+1 − v_i). The
// wrench must be taken out of what is observed, or the observer would cancel the push: without a
// measured wrench there is none. A wrench that is late, and a torque that acts late, are put beside
// the motion that they belong to. Source: De Luca, Mattone, "Sensorless robot collision detection
// and hybrid force/motion control", ICRA 2005.
#pragma once

#include <array>

#include "impedraw/control/arm_terms.h"

namespace impedraw {

struct ObserverSettings {
  bool enabled = true;       // needs a measured wrench
  double bandwidth = 200.0;  // K_o [rad/s]
  double limit = 40.0;       // of each |r_j| [Nm]

  void validate() const;  // throws InputError naming the setting and what is valid
};

class MomentumObserver {
 public:
  // The wrench is `wrench_age` old beyond the step that has just ended, the torque acts
  // `torque_delay` after it was computed [s]; both are rounded to steps. Throws InputError for what
  // is out of range.
  MomentumObserver(const ObserverSettings& settings, int joints, double dt, double wrench_age,
                   double torque_delay);

  // At the start of a step: `arm` is measured now, F_ext [N, Nm] at E in W came in just now.
  // Returns r.
  const JointVector& update(const ArmTerms& arm, const Vector6& F_ext) noexcept;
  // At its end: what was commanded, after all limits.
  void commanded(const JointVector& tau) noexcept;

  const JointVector& disturbance() const { return r_; }  // r [Nm]
  void pause() noexcept { step_ = 0; }  // a step without a wrench: r stays, history begins anew
  void reset() noexcept;                // r = 0, history forgotten

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

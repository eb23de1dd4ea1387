// Gives the tip the arm's own inertia back during a hard blow that asks the torques to change
// faster than they may. A lighter tip multiplies the force of its contact by Λ M_d⁻¹. Torques at
// the limit of their rate lag behind that: the pen is thrown up, and hammers.
//
// Law       1 − s ← (1 − s) exp(−Δt/kGive)  from the kPatience-th step in a row on that follows one
//                                           at its limits, with more than kHard times F_n
//           s ← s exp(−Δt/kReturn)          else
//           M_d and B of s: tip_impedance.h
// Requires  a measured wrench; one call every dt
#pragma once

#include <cmath>

#include "impedraw/control/contact.h"

namespace impedraw {

class HurriedTorque {
 public:
  static constexpr double kGive = 0.01, kReturn = 0.3;  // [s]
  static constexpr double kHard = 2.0;
  static constexpr int kPatience = 5;  // a touch is at the limits for less

  explicit HurriedTorque(const ImpedanceSettings& s) noexcept
      : light_(s.inertia != InertiaShaping::natural),
        given_(std::exp(-s.timing.dt / kGive)),
        kept_(std::exp(-s.timing.dt / kReturn)) {}

  // One step, with the measured wrench. limited: the torques of the step before were. Returns s.
  double update(const Contact& contact, const Wrench& F_ext, bool limited) noexcept {
    if (!light_) return 0.0;
    const bool hard = contact.mode == ContactMode::contact &&
                      contact.n.dot(F_ext.head<3>()) > kHard * contact.force;
    hurried_ = hard && limited ? hurried_ + 1 : 0;
    if (hurried_ >= kPatience)
      own_ = 1.0 - (1.0 - own_) * given_;
    else
      own_ = own_ > kNone ? own_ * kept_ : 0.0;
    return own_;
  }
  void reset() noexcept {
    own_ = 0.0;
    hurried_ = 0;
  }

 private:
  static constexpr double kNone = 1e-3;

  bool light_;           // there is an inertia to give back
  double given_, kept_;  // in a step
  double own_ = 0.0;     // s
  int hurried_ = 0;      // steps in a row
};

}  // namespace impedraw

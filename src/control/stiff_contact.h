// Gives the tip the arm's own inertia back where the contact is stiffer than the loop is stable
// with (contact_stability.h): a measured force that makes the tip lighter comes too late there, and
// the pen hammers.
//
// Swing     from one turn of the measured normal force to the next, more than kSwing times the
//           push, within kHalfPeriod of contact, and no less than kLasting times the swing before.
//           Blows at touchdown fade, and rough ground turns the force once or twice, or slower.
// Law       M_d⁻¹ ← (1 − s) M_d⁻¹ + s Λ⁻¹,  1 − s halved by the kSwings-th swing in a row and by
//           each that follows. With s = 1 the measured force does not act on its own contact. s is
//           kept when the pen lifts, as workpiece and tip stay as stiff.
// Source    Dimeas and Aspragathos, IEEE Trans. Haptics 9(2), 2016: such an oscillation is detected
//           in the loop, and an admittance made heavier until it ends
// Requires  a measured wrench; one call every dt
#pragma once

#include <algorithm>
#include <cmath>

#include "impedraw/control/contact.h"

namespace impedraw {

class StiffContact {
 public:
  static constexpr double kSwing = 0.5, kLasting = 0.8;
  static constexpr double kLeastPush = 3.0;     // noise and a blow are as large under less [N]
  static constexpr double kTouch = 0.1;         // share of the push from which the pen touches
  static constexpr double kHalfPeriod = 0.025;  // [s]
  static constexpr int kSwings = 4;

  explicit StiffContact(const ImpedanceSettings& s) noexcept
      : dt_(s.timing.dt), light_(s.inertia != InertiaShaping::natural) {}

  // One step, with the measured wrench. Returns s.
  double update(const Contact& contact, const Wrench& F_ext) noexcept {
    if (contact.mode != ContactMode::contact || !light_) return own_;
    const double force = contact.n.dot(F_ext.head<3>()),
                 least = std::max(contact.force, kLeastPush);
    if (force > kTouch * least) since_ += dt_;
    turn_ = rising_ ? std::max(turn_, force) : std::min(turn_, force);
    if (std::abs(force - turn_) <= kSwing * least) return own_;
    const double swing = std::abs(turn_ - last_turn_);
    swings_ = since_ < kHalfPeriod && swing >= kLasting * swing_ ? swings_ + 1 : 0;
    if (swings_ >= kSwings) own_ += 0.5 * (1.0 - own_);
    swing_ = swing;
    last_turn_ = turn_;
    turn_ = force;
    rising_ = !rising_;
    since_ = 0.0;
    return own_;
  }
  double own() const noexcept { return own_; }

 private:
  double dt_;
  bool light_;                            // there is an inertia to give back
  double own_ = 0.0;                      // s
  double turn_ = 0.0;                     // extreme force since the last turn [N]
  double last_turn_ = 0.0, swing_ = 0.0;  // force at that turn, swing before it [N]
  double since_ = 0.0;                    // that turn, in contact [s]
  bool rising_ = true;
  int swings_ = 0;  // in a row
};

}  // namespace impedraw

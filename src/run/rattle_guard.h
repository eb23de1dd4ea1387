// Notices a pen that hammers on the canvas: a measured force that swings about its mean by more
// than twice the push. A tip or a canvas that is stiffer than the controller believes does that.
// So does what the cameras do not resolve, wires for instance, from one to the next: the tip then
// meets the canvas at heights that differ.
#pragma once

#include <algorithm>
#include <cmath>

#include "impedraw/control/contact_mode.h"

namespace impedraw {

class RattleGuard {
 public:
  // Called once per cycle: the measured normal force, the push [N] and the tip's distance from the
  // surface as estimated [m]. Cycles in which the pen comes back to the canvas do not count. True
  // in the cycle in which the guard trips.
  bool update(double force, ContactMode mode, double push, double distance, double dt) noexcept {
    if (mode == ContactMode::free) *this = {};
    if (mode != ContactMode::contact || !(push > 0.0) || !std::isfinite(force)) return false;
    const double share = force / push, gain = dt / (kFilter + dt);
    if (share > kHeld && std::isfinite(distance)) {
      if (!touched_) lowest_ = highest_ = distance;
      touched_ = true;
      lowest_ += distance < lowest_ ? distance - lowest_ : gain * (distance - lowest_);
      highest_ += distance > highest_ ? distance - highest_ : gain * (distance - highest_);
    }
    mean_ += gain * (share - mean_);
    mean_square_ += gain * (share * share - mean_square_);
    return deviation() > kTrip;
  }

  // Between the distances from the estimated surface at which the canvas held the tip lately [m].
  double unevenness() const { return highest_ - lowest_; }
  // What a surface that the cameras resolve stays below [m].
  static constexpr double kUnseen = 0.5e-3;

  // Standard deviation, as a share of the push.
  double deviation() const { return std::sqrt(std::max(0.0, mean_square_ - mean_ * mean_)); }

 private:
  // The roughest surfaces that are drawn on reach 0.6; a blow at touchdown is over in 10 ms.
  static constexpr double kTrip = 2.0;    // standard deviation as a share of the push
  static constexpr double kFilter = 0.3;  // [s]
  static constexpr double kHeld = 0.2;    // least force of a canvas that holds the tip, as a share

  double mean_ = 1.0, mean_square_ = 1.0;  // of the force, as a share of the push
  double lowest_ = 0.0, highest_ = 0.0;    // distances when held, forgotten at the filter's rate
  bool touched_ = false;
};

}  // namespace impedraw

// Notices a pen that hammers on the canvas: a measured force that swings about its mean by more
// than twice the push. A tip or a canvas that is stiffer than the controller believes does that.
#pragma once

#include <algorithm>
#include <cmath>

#include "impedraw/control/contact_mode.h"

namespace impedraw {

class RattleGuard {
 public:
  // Called once per cycle: the measured normal force and the push [N]. Cycles in which the pen
  // comes back to the canvas do not count. True in the cycle in which the guard trips.
  bool update(double force, ContactMode mode, double push, double dt) noexcept {
    if (mode == ContactMode::free) mean_ = mean_square_ = 1.0;
    if (mode != ContactMode::contact || !(push > 0.0) || !std::isfinite(force)) return false;
    const double share = force / push, gain = dt / (kFilter + dt);
    mean_ += gain * (share - mean_);
    mean_square_ += gain * (share * share - mean_square_);
    return deviation() > kTrip;
  }

  // Standard deviation, as a share of the push.
  double deviation() const { return std::sqrt(std::max(0.0, mean_square_ - mean_ * mean_)); }

 private:
  // The roughest surfaces that are drawn on reach 0.6; a blow at touchdown is over in 10 ms.
  static constexpr double kTrip = 2.0;    // standard deviation as a share of the push
  static constexpr double kFilter = 0.3;  // [s]

  double mean_ = 1.0, mean_square_ = 1.0;  // of the force, as a share of the push
};

}  // namespace impedraw

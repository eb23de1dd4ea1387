// Notices a pen that hammers on the canvas: a measured force that swings about the push by more than
// twice the push. A tip or a canvas that is stiffer than the controller believes does that.
#pragma once

#include <cmath>

#include "impedraw/control/contact_mode.h"

namespace impedraw {

class RattleGuard {
 public:
  // Called once per cycle: the measured normal force and the push [N]. Cycles in which the pen comes
  // back to the canvas do not count. True in the cycle in which the guard trips.
  bool update(double force, ContactMode mode, double push, double dt) noexcept {
    if (mode == ContactMode::free) mean_square_ = 0.0;
    if (mode != ContactMode::contact || !(push > 0.0) || !std::isfinite(force)) return false;
    const double off = (force - push) / push;
    mean_square_ += (off * off - mean_square_) * dt / (kFilter + dt);
    return mean_square_ > kTrip * kTrip;
  }

  double deviation() const { return std::sqrt(mean_square_); }  // RMS, as a share of the push

 private:
  // The roughest surfaces that are drawn on reach 0.6; a blow at touchdown is over in 10 ms.
  static constexpr double kTrip = 2.0;    // RMS deviation as a share of the push
  static constexpr double kFilter = 0.3;  // [s]

  double mean_square_ = 0.0;
};

}  // namespace impedraw

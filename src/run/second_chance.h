// Decides if a drawing goes on after a motion that had to be damped. An arm that drew well before
// cannot pass this one place, a singular posture for instance. Otherwise the arm, its set-up or a
// hand is to blame, and the run ends.
#pragma once

#include "impedraw/run/cycle.h"

namespace impedraw {

class SecondChance {
 public:
  static constexpr int kMost = 3;        // in one run
  static constexpr double kDrawn = 2.0;  // with ink, since the last one [s]
  static constexpr double kAlone = 0.5;  // since a hand pushed [s]
  static constexpr double kHand = 20.0;  // force that the push of the pen does not explain [N]

  // possible: the surface is perceived, and ink is wanted.
  explicit SecondChance(bool possible) : possible_(possible) {}

  // After each cycle.
  void update(const Cycle& cycle) noexcept {
    if (cycle.inked && cycle.desired.stroke >= 0) drawn_ += cycle.dt;
    const Eigen::Vector3d unexplained = cycle.F_ext.head<3>() - cycle.out.push * cycle.out.n_WD;
    alone_ = unexplained.norm() < kHand ? alone_ + cycle.dt : 0.0;
    stands_ = !cycle.canvas.follows();
  }
  bool given() const noexcept {
    return possible_ && stands_ && taken_ < kMost && drawn_ > kDrawn && alone_ > kAlone;
  }
  // The motion was damped, and the drawing goes on.
  void take() noexcept {
    ++taken_;
    drawn_ = 0.0;
  }

 private:
  bool possible_, stands_ = false;
  int taken_ = 0;
  double drawn_ = 0.0, alone_ = 0.0;  // [s]
};

}  // namespace impedraw

// Tells whether a canvas that may be moved by hand stands still, from its estimated motion.
//
// It moves once its speed at the tip exceeds kMoves or its turning kTurns; it stands once both have
// been below half of that for kConfirm.
#pragma once

#include "impedraw/control/canvas_estimate.h"

namespace impedraw {

class RestMonitor {
 public:
  static constexpr double kMoves = 8e-3;   // [m/s]
  static constexpr double kTurns = 0.06;   // [rad/s]
  static constexpr double kConfirm = 0.5;  // [s]

  // Once per cycle of dt [s].
  void update(const FrameMotion& canvas, const Eigen::Vector3d& p_WE, double dt) noexcept {
    const double speed = canvas.velocity_at(p_WE).norm(), turn = canvas.w.norm();
    if (speed > kMoves || turn > kTurns) {
      moves_ = true;
      rests_ = 0.0;
    } else if (moves_) {
      rests_ = speed < 0.5 * kMoves && turn < 0.5 * kTurns ? rests_ + dt : 0.0;
      moves_ = rests_ < kConfirm;
    }
  }
  bool moves() const noexcept { return moves_; }

 private:
  bool moves_ = false;
  double rests_ = 0.0;  // [s]
};

}  // namespace impedraw

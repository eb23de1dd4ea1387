// The time for which a plan has waited since it last drew. Waits add up until a stroke is drawn: a
// canvas that rests for a moment, again and again, ends the run, too.
#pragma once

namespace impedraw {

class WaitMonitor {
 public:
  explicit WaitMonitor(double most) : most_(most) {}  // [s]

  // Once per cycle of dt [s]: whether the plan waits, and whether it draws. True in a cycle in
  // which it waits and has waited for too long.
  bool update(bool waits, bool draws, double dt) noexcept {
    if (waits)
      waited_ += dt;
    else if (draws)
      waited_ = 0.0;
    return waits && waited_ >= most_;
  }
  double waited() const noexcept { return waited_; }  // [s]

 private:
  double most_, waited_ = 0.0;  // [s]
};

}  // namespace impedraw

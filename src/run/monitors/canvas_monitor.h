// Makes a plan wait while the canvas is lost, moves, or comes to rest.
#pragma once

#include <fmt/format.h>

#include "impedraw/control/canvas_estimate.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

// The time for which a plan has waited since it last drew. Waits add up until a stroke is drawn: a
// canvas that rests for a moment, again and again, ends the run, too.
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

// Tells whether a canvas that may be moved by hand stands still, from its estimated motion.
//
// It moves once its speed at the tip exceeds kMoves or its turning kTurns; it stands once both have
// been below half of that for kConfirm.
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

// Holds the plan while the canvas is lost to the cameras or, where the pen waits for that, while it
// moves. A wait of kMostWait without a stroke between ends the run. A canvas that is known again
// after the pen has let go of it ends the path: the rest would be followed in the air.
class CanvasMonitor {
 public:
  static constexpr double kMostWait = 45.0;  // [s]

  // waits_for_rest: strokes begin while the canvas stands.
  explicit CanvasMonitor(bool waits_for_rest) : waits_for_rest_(waits_for_rest) {}

  void begin_path() noexcept { let_go_ = false; }

  // Names what the plan waits for; null: nothing.
  const char* waits_for(const Cycle& cycle) const noexcept {
    // A lift goes on: nearer to a canvas that nobody sees, the pen would wait for it to hit.
    if (cycle.canvas.lost() && cycle.desired.phase != Phase::lift)
      return "the cameras to know the canvas again";
    const bool up = cycle.desired.stroke < 0 && cycle.out.mode == ContactMode::free;
    return rest_.moves() && up ? "the canvas to rest" : nullptr;
  }

  // After each cycle in which the pen follows a path: whether the plan is held.
  Verdict hold(const Cycle& cycle) noexcept {
    if (waits_for_rest_ && cycle.canvas.joined())
      rest_.update(cycle.canvas.estimate().motion, cycle.arm.X_WE.p, cycle.dt);
    const char* const what = waits_for(cycle);
    if (!what) return {};
    Verdict verdict;
    verdict.severity = Severity::hold;
    return verdict;
  }

  // After that. paused: by a person, which does not count as a wait.
  Verdict judge(const Cycle& cycle, bool paused) {
    const char* const what = paused ? nullptr : waits_for(cycle);
    if (wait_.update(what, cycle.desired.stroke >= 0, cycle.dt))
      return {.severity = Severity::lift,
              .cause = cycle.canvas.lost() ? unknown_text(cycle) : moving_text(cycle),
              .rise = Verdict::Rise::let_go};
    if (cycle.canvas.lost() && cycle.out.mode == ContactMode::retreat) let_go_ = true;
    return {let_go_ && !cycle.canvas.lost() ? Severity::leave : Severity::none};
  }

  bool let_go() const noexcept { return let_go_; }           // during this path
  double waited() const noexcept { return wait_.waited(); }  // [s]

 private:
  static std::string unknown_text(const Cycle& cycle) {
    return fmt::format(
        "no camera has known the canvas for {:.0f} s, at t = {:.3f} s; the {} was lifted",
        kMostWait, cycle.next_run_time(), cycle.tool);
  }
  static std::string moving_text(const Cycle& cycle) {
    const double speed = cycle.canvas.estimate().motion.velocity_at(cycle.arm.X_WE.p).norm();
    return fmt::format(
        "the canvas did not come to rest within {:.0f} s, at t = {:.3f} s: it moves at {:.3g} mm/s "
        "under the {}, and rests below {:.2g} mm/s; perception.frames.wait_for_rest=false draws "
        "on a canvas that moves",
        kMostWait, cycle.next_run_time(), 1e3 * speed, cycle.tool, 0.5e3 * RestMonitor::kMoves);
  }

  bool waits_for_rest_;
  RestMonitor rest_;
  WaitMonitor wait_{kMostWait};
  bool let_go_ = false;
};

}  // namespace impedraw

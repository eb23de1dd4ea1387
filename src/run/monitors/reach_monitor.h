// Lets the pen go of a canvas that moves to where the arm cannot follow: the tip is kFar behind the
// point that it is driven to, for kConfirm.
#pragma once

#include <fmt/format.h>

#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

class ReachMonitor {
 public:
  static constexpr double kFar = 15e-3;    // [m]
  static constexpr double kConfirm = 0.1;  // [s]

  // goes_on: the drawing may go on elsewhere; otherwise the run ends.
  explicit ReachMonitor(bool goes_on) : goes_on_(goes_on) {}

  // After each cycle in which the pen follows a path.
  Verdict judge(const Cycle& cycle) {
    if (!cycle.canvas.joined()) return {};
    far_for_ = cycle.lag().norm() > kFar ? far_for_ + cycle.dt : 0.0;
    if (far_for_ < kConfirm) return {};
    Verdict verdict{.severity = Severity::lift, .rise = Verdict::Rise::let_go};
    if (goes_on_) {
      verdict.end = RunEnd::finished;
      far_for_ = 0.0;
      return verdict;
    }
    const Eigen::Vector3d& p = cycle.out.p_WD;
    verdict.cause = fmt::format(
        "the canvas{} left the arm's reach at t = {:.3f} s, at ({:.2f}, {:.2f}, {:.2f}) m; the pen "
        "was lifted",
        cycle.canvas.lost() ? ", as it was foreseen since no camera knows it," : "",
        cycle.next_run_time(), p.x(), p.y(), p.z());
    return verdict;
  }

 private:
  bool goes_on_;
  double far_for_ = 0.0;  // [s]
};

}  // namespace impedraw

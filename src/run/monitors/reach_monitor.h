// Lets the pen go of a canvas that moves to where the arm cannot follow: the tip is kFar behind the
// point that it is driven to, for kConfirm, or a joint is faster than the law may ask for, for
// kRaces. The plan's clock stands by then, so that the canvas alone drives it: near a stretched
// posture it would soon be faster than the arm can be.
#pragma once

#include <utility>

#include <fmt/format.h>

#include "impedraw/control/joint_speed_shares.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

class ReachMonitor {
 public:
  static constexpr double kFar = 15e-3;    // [m]
  static constexpr double kConfirm = 0.1;  // [s]
  static constexpr double kRaces = 0.03;   // [s]

  // goes_on: the drawing may go on elsewhere; otherwise the run ends. speed: the joints' limits
  // [rad/s].
  ReachMonitor(bool goes_on, JointVector speed) : goes_on_(goes_on), speed_(std::move(speed)) {}

  // After each cycle in which the canvas takes the pen along.
  bool loses(const Cycle& cycle) {
    far_for_ = cycle.lag().norm() > kFar ? far_for_ + cycle.dt : 0.0;
    races_for_ = goes_on_ && cycle.speed_share(speed_) > JointSpeedShares::kLaw
                     ? races_for_ + cycle.dt
                     : 0.0;
    if (far_for_ < kConfirm && races_for_ < kRaces) return false;
    far_for_ = races_for_ = 0.0;
    return true;
  }

  // The same, while the pen follows a path.
  Verdict judge(const Cycle& cycle) {
    if (!cycle.canvas.joined() || !loses(cycle)) return {};
    Verdict verdict{.severity = Severity::lift, .rise = Verdict::Rise::let_go};
    if (goes_on_) {
      verdict.end = RunEnd::finished;
      return verdict;
    }
    const Eigen::Vector3d& p = cycle.out.p_WD;
    verdict.cause = fmt::format(
        "the canvas{} left the arm's reach at t = {:.3f} s, at ({:.2f}, {:.2f}, {:.2f}) m; the {} "
        "was lifted",
        cycle.canvas.lost() ? ", as it was foreseen since no camera knows it," : "",
        cycle.next_run_time(), p.x(), p.y(), p.z(), cycle.tool);
    return verdict;
  }

 private:
  bool goes_on_;
  JointVector speed_;                       // [rad/s]
  double far_for_ = 0.0, races_for_ = 0.0;  // [s]
};

}  // namespace impedraw

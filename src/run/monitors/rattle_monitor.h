// Notices a pen that hammers on the canvas: a measured force that swings about its mean by more
// than twice the push. A tip or a canvas that is stiffer than the controller believes does that.
// So does what the cameras do not resolve, wires for instance, from one to the next: the tip then
// meets the canvas at heights that differ.
#pragma once

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "impedraw/control/joint_speed_shares.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

class RattleMonitor {
 public:
  // stiffness_max: of the contact, as the law assumes [N/m]. feels_walls: a place may be left.
  explicit RattleMonitor(double stiffness_max = 0.0, bool feels_walls = false)
      : stiffness_max_(stiffness_max), feels_walls_(feels_walls) {}

  // Called once per cycle: the measured normal force, the push [N] and the tip's distance from the
  // surface as estimated [m]. Cycles in which the pen comes back to the canvas do not count. True
  // while the pen hammers.
  bool update(double force, ContactMode mode, double push, double distance, double dt) noexcept {
    if (mode == ContactMode::free) *this = RattleMonitor(stiffness_max_, feels_walls_);
    if (mode != ContactMode::contact || !(push > 0.0) || !std::isfinite(force)) return false;
    const double share = force / std::max(push, kLeastPush), gain = dt / (kFilter + dt);
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

  // The same, after a cycle: a place that the cameras do not resolve is left, if `feels_walls`; a
  // canvas that is too stiff ends the run.
  Verdict judge(const Cycle& cycle) {
    if (!update(cycle.normal_force(), cycle.out.mode, cycle.out.push, cycle.surface.distance,
                cycle.dt))
      return {};
    Verdict verdict;
    if (unevenness() > kUnseen && feels_walls_) {
      verdict.severity = Severity::lift;
      verdict.end = RunEnd::finished;
      verdict.rise = Verdict::Rise::a_little;
      return verdict;
    }
    verdict.severity = Severity::brake;
    verdict.calm = JointSpeedShares::kStill;
    const double push = cycle.out.push;
    verdict.cause = fmt::format(
        "the {} hammered on the canvas at t = {:.3f} s, ± {:.2g} N at a push of {:.3g} N: tip or "
        "canvas may be stiffer than control.contact_stiffness_max, {:.3g} N/m",
        cycle.tool, cycle.run_time, deviation() * std::max(push, kLeastPush), push, stiffness_max_);
    return verdict;
  }

  // Span of the distances from the estimated surface at which the canvas held the tip lately [m].
  double unevenness() const { return highest_ - lowest_; }
  // Unevenness that no surface reaches if the cameras resolve it [m].
  static constexpr double kUnseen = 0.5e-3;

  // Standard deviation, as a share of the push, or of kLeastPush.
  double deviation() const { return std::sqrt(std::max(0.0, mean_square_ - mean_ * mean_)); }

 private:
  // The roughest surfaces that are drawn on reach 0.6; a blow at touchdown is over in 10 ms.
  static constexpr double kTrip = 2.0;       // standard deviation as a share of the push
  static constexpr double kLeastPush = 1.0;  // a touchdown's blow is no lighter under less [N]
  static constexpr double kFilter = 0.3;     // [s]
  static constexpr double kHeld = 0.2;  // least force of a canvas that holds the tip, as a share

  double stiffness_max_;
  bool feels_walls_;
  double mean_ = 1.0, mean_square_ = 1.0;  // force as a share of the push
  double lowest_ = 0.0, highest_ = 0.0;    // distances when held, forgotten at the filter's rate
  bool touched_ = false;
};

}  // namespace impedraw

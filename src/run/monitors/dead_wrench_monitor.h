// Notices a force sensor that is dead: the arm's own torques tell that something holds the pen, and
// the measured wrench tells of nothing.
//
// For 8 ms a force along the pen of three pushes and 15 N, of which the wrench tells less than 0.4
// pushes and 2 N, while the pen is 0.5 mm beneath the surface that was seen or touched, or 5 mm
// behind on its way to one. On the way down it takes 45 N, as friction in the joints holds it, too.
// A hand on the arm does not put the pen there, and the canvas is felt beside it.
#pragma once

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

class DeadWrenchMonitor {
 public:
  static constexpr double kLeast = 15.0, kInAir = 45.0;       // [N]
  static constexpr double kPushes = 3.0, kTold = 0.4;         // of the push
  static constexpr double kBeneath = 0.5e-3, kBehind = 5e-3;  // [m]
  static constexpr double kConfirm = 8e-3;                    // [s]

  // After each cycle. held: force along the pen's −z by the arm's torques (SignMonitor::held()).
  Verdict judge(const Cycle& cycle, double held) {
    const ContactMode mode = cycle.out.mode;
    const bool down = mode == ContactMode::contact || mode == ContactMode::approach;
    const bool there = cycle.surface.status == SurfaceStatus::ok
                           ? cycle.surface.distance < -kBeneath
                           : cycle.lag().dot(cycle.arm.X_WE.R.col(2)) > kBehind;
    const double told = std::abs(cycle.normal_force());
    const double push = std::max(kLeast / kPushes, cycle.out.push);
    const double least = mode == ContactMode::contact ? kLeast : kInAir;
    const bool unfelt = held > std::max(least, kPushes * push) && told < kTold * push;
    unfelt_ = down && there && unfelt ? unfelt_ + cycle.dt : 0.0;
    if (unfelt_ < kConfirm) return {};
    return {Severity::damp, fmt::format("the {} is held as by {:.0f} N, of which the measured "
                                        "wrench tells {:.1f} N at t = {:.3f} s",
                                        cycle.tool, held, told, cycle.next_run_time())};
  }

 private:
  double unfelt_ = 0.0;  // so long [s]
};

}  // namespace impedraw

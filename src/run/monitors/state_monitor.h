// Ends a run whose arm cannot be driven: the driver has a fault, or the control law was not given a
// usable joint state for kBadStateTime, or a fresh wrench for kStaleWrenchTime, in which the pen
// leaves the surface.
#pragma once

#include <fmt/format.h>

#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

inline constexpr double kBadStateTime = 0.2, kStaleWrenchTime = 1.0;  // [s]

class StateMonitor {
 public:
  // After each cycle. fault: the driver's; empty while the arm can be driven.
  Verdict judge(const Cycle& cycle, const std::string& fault) {
    const ControlStatus& status = cycle.out.status;
    bad_ = status.bad_input || status.stale_state ? bad_ + cycle.dt : 0.0;
    stale_wrench_ = status.stale_wrench ? stale_wrench_ + cycle.dt : 0.0;
    if (!fault.empty()) return {Severity::lose, fault};
    if (bad_ <= kBadStateTime && stale_wrench_ > kStaleWrenchTime)
      return {Severity::halt, fmt::format("no fresh wrench came for {:.1f} s up to t = {:.3f} s",
                                          kStaleWrenchTime, cycle.run_time)};
    if (bad_ <= kBadStateTime) return {};
    return {Severity::lose,
            fmt::format("the controller was given {} for {:.1f} s up to t = {:.3f} s",
                        status.bad_input ? "numbers that are not finite" + bad_input(cycle)
                                         : std::string("joint states that are stale"),
                        kBadStateTime, cycle.run_time)};
  }

 private:
  // Names the input that is not finite; empty: none.
  static std::string bad_input(const Cycle& cycle) {
    const ArmTerms& arm = cycle.arm;
    if (!arm.M.allFinite() || !arm.g.allFinite()) return ", as joint positions,";
    if (!arm.v.allFinite()) return ", as joint velocities,";
    return cycle.F_ext.allFinite() ? "" : ", as the wrench,";
  }

  double bad_ = 0.0, stale_wrench_ = 0.0;  // since the last usable state, fresh wrench [s]
};

}  // namespace impedraw

// Notices a force-torque sensor that stays at the end of its range: a lie, or a push of any size.
// The estimator passes such readings over and keeps its last wrench (wrench_estimator.h), which
// would stand for ever. A blow is over in 10 ms.
#pragma once

#include <fmt/format.h>

#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"
#include "impedraw/sensing/wrench_estimator.h"

namespace impedraw {

class RangeMonitor {
 public:
  static constexpr double kConfirm = 20e-3;  // [s]

  explicit RangeMonitor(const WrenchEstimatorSettings& sensor)
      : force_(sensor.range_force), torque_(sensor.range_torque) {}

  Verdict judge(const Cycle& cycle) {
    const Wrench& w = cycle.state->wrench;
    const bool at_end =
        w.head<3>().cwiseAbs().maxCoeff() >= force_ || w.tail<3>().cwiseAbs().maxCoeff() >= torque_;
    beyond_ = at_end && cycle.tared ? beyond_ + cycle.dt : 0.0;  // before: tare_monitor.h
    if (beyond_ < kConfirm - 0.5 * cycle.dt) return {};
    return {Severity::halt,
            fmt::format("the wrench sensor stays at the end of its range ({:.3g} N, {:.3g} Nm) at "
                        "t = {:.3f} s",
                        force_, torque_, cycle.run_time)};
  }

 private:
  double force_, torque_, beyond_ = 0.0;  // beyond_ [s]
};

}  // namespace impedraw

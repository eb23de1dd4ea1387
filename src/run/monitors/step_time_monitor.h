// Lifts the pen if control steps come too late (control/step_watchdog.h).
#pragma once

#include <fmt/format.h>

#include "impedraw/control/step_watchdog.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

class StepTimeMonitor {
 public:
  // After each cycle. From the first late step on, every cycle is judged the same.
  Verdict judge(const Cycle& cycle) {
    if (!steps_.update(cycle.step_time)) return {};
    return {Severity::lift,
            fmt::format("a control step took too long at t = {:.3f} s; the {} was lifted",
                        cycle.run_time, cycle.tool)};
  }

 private:
  StepWatchdog steps_;
};

}  // namespace impedraw

// Ends a run whose wrench sensor could not be tared while the arm rested at its beginning.
#pragma once

#include <fmt/format.h>

#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

class TareMonitor {
 public:
  // hold: how long the arm rests at first; tare_time: how long the sensor needs [s].
  TareMonitor(double hold, double tare_time) : hold_(hold), tare_time_(tare_time) {}

  // The arm moves for so long before it rests [s].
  void moves_first(double duration) noexcept { moved_for_ = duration; }

  // After each cycle.
  Verdict judge(const Cycle& cycle) const {
    if (cycle.time <= hold_ + moved_for_ || cycle.tared) return {};
    return {Severity::lose,
            fmt::format("the wrench sensor could not be tared: within the first {:.2g} s the arm "
                        "must rest for {:.2g} s, with no reading at its range",
                        hold_, tare_time_)};
  }

 private:
  double hold_, tare_time_, moved_for_ = 0.0;  // [s]
};

}  // namespace impedraw

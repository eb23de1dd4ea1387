// What watching costs: how far behind a viewer is, and what a run loses by it.
#pragma once

#include <limits>

#include "impedraw/experiment/prepare.h"

namespace impedraw {

struct LiveCosts {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  double delay_ms = kUnknown, delay_p99_ms = kUnknown;  // from the loop to a socket's reader
  double slower =
      kUnknown;  // real_time_factor without a viewer / with one; medians of alternating runs
  double factor = kUnknown;  // real_time_factor with a viewer
};

LiveCosts live_costs(Prepared& experiment);

}  // namespace impedraw

// A curve thinned without losing peaks: each bin of steps keeps its smallest and largest value.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "impedraw/log/run_data.h"
#include "impedraw/metrics/ink_match.h"

namespace impedraw {

struct Envelope {
  std::vector<double> t, v;  // in order of time; NaN if a whole bin has no value
};

// Returns at most about `points` points: the smallest and the largest value of each bin, each at
// its own time. Short series stay complete. v(i) is the value at t[i].
Envelope envelope(std::span<const double> t, const std::function<double(std::size_t)>& v,
                  std::size_t points);

}  // namespace impedraw

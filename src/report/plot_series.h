// The data of a comparison's plots, thinned without losing peaks: each bin of steps keeps its
// smallest and largest value.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include <nlohmann/json_fwd.hpp>

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

// force, push [N], tilt, normal_error [deg]: {t, v}; strokes: [[begin, end] in s]; target, ink:
// polylines from above, [[x, y] in mm].
nlohmann::json plot_series(const RunData& run, const InkMatch& drawn, std::size_t points = 3000);

}  // namespace impedraw

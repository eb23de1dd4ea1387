// Reduces the number of points of lines and curves for display. Private to src/report.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "impedraw/log/run_data.h"
#include "impedraw/metrics/ink_match.h"

namespace impedraw {

using Line2d = std::vector<Eigen::Vector2d>;

// Removes points that lie within `tolerance` of the remaining line; the ends stay. Works in one
// pass. From the last kept point, it intersects the wedges of directions that pass each following
// point within the tolerance. A point nearer than its predecessor ends the search, so a line that
// turns back keeps its tip.
Line2d decimated(const Line2d& line, double tolerance);

// Decimates all lines with one tolerance: the smallest finest · 2^(k/2) that leaves at most `most`
// points in total. Stops at about 200 times the finest. Returns the tolerance.
double decimate_to(std::vector<Line2d>& lines, double finest, std::size_t most);

// A curve thinned without losing peaks: each bin of steps keeps its smallest and largest value.

struct Envelope {
  std::vector<double> t, v;  // in order of time; NaN if a whole bin has no value
};

// Returns at most about `points` points: the smallest and the largest value of each bin, each at
// its own time. Short series stay complete. v(i) is the value at t[i].
Envelope envelope(std::span<const double> t, const std::function<double(std::size_t)>& v,
                  std::size_t points);

}  // namespace impedraw

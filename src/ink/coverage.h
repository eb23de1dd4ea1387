// Length of a target line that has ink nearby, and the spans that have none.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/ink/segments.h"

namespace impedraw {

// In the unit of the points.
struct Coverage {
  double length = 0.0;   // of the target
  double covered = 0.0;  // length with ink within reach
  // Lengths, in order along the target. If the target's last point repeats the first, a span across
  // the joint counts as one.
  std::vector<double> uncovered_spans;
};

// Exact: a target point counts as covered if some point of an ink segment is within `reach` of it.
Coverage cover(const std::vector<Eigen::Vector3d>& target, const Segments& ink, double reach);

// Returns the part [first, second] of the segment s that is within `reach` of `ink`, as lengths
// from s.a; first > second: none.
std::pair<double, double> within_reach(const Segment& s, const Segment& ink, double reach);

}  // namespace impedraw

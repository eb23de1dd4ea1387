// How much of a target line has ink near it, by length, and which spans have none.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/ink/segments.h"

namespace impedraw {

// In the unit of the points.
struct Coverage {
  double length = 0.0;   // of the target
  double covered = 0.0;  // of it, with ink within reach
  std::vector<double>
      // lengths, in order along the target; where its last point repeats the first, the span across
      // the
      uncovered_spans;
  // joint is one
};

// Exact: a point of the target counts when some point of a segment of ink lies within `reach` of
// it.
Coverage cover(const std::vector<Eigen::Vector3d>& target, const Segments& ink, double reach);

// The part [first, second] of the segment s, in lengths along it from s.a, that lies within `reach`
// of `ink`; first > second: none.
std::pair<double, double> within_reach(const Segment& s, const Segment& ink, double reach);

}  // namespace impedraw

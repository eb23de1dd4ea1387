// A run's ink against its target, row by row: what the metrics average and the pictures show.
#pragma once

#include <vector>

#include "impedraw/ink/ink_lines.h"
#include "impedraw/ink/segments.h"
#include "impedraw/log/run_data.h"

namespace impedraw {

struct InkMatch {
  std::vector<InkLine> lines;     // ink, cut where it ends and where /stroke changes
  std::vector<StrokeSpan> spans;  // the plan's passes over strokes, in order of time
  std::vector<int> strokes;       // every stroke that target or plan know of, ascending
  std::vector<std::vector<Eigen::Vector3d>>
      targets;  // the target polyline of each of `strokes`; empty where it has none
  std::vector<double>
      // n; distance of the contact point to the target of its own stroke [m]; NaN but on pen-down
      // ink
      error;
};

InkMatch match_ink(const RunData& run);

// True where /stroke is −1 and the row's time is more than 0.5 s from both ends of every stroke:
// ink here is a fault.
std::vector<bool> pen_must_be_up(const RunData& run, const InkMatch& drawn);

}  // namespace impedraw

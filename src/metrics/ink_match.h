// Matches a run's ink to its target, step by step. Metrics and pictures are based on the result.
#pragma once

#include <vector>

#include "impedraw/ink/ink_lines.h"
#include "impedraw/ink/segments.h"
#include "impedraw/log/run_data.h"

namespace impedraw {

// Spacing in a search tree of lines [m]; affects its speed, not its results.
inline constexpr double kSampleSpacing = 0.25e-3;

struct InkMatch {
  std::vector<InkLine> lines;     // ink lines, split at their ends and where /stroke changes
  std::vector<StrokeSpan> spans;  // the plan's passes over strokes, in order of time
  std::vector<int> strokes;       // every stroke in the target or the plan, ascending
  std::vector<std::vector<Eigen::Vector3d>>
      targets;  // the target polyline of each of `strokes`; empty if it has none
  std::vector<double>
      // n; distance of the contact point from the target of its own stroke [m]; NaN except on
      // pen-down ink
      error;
};

InkMatch match_ink(const RunData& run);

// True where /stroke is −1 and the time is more than 0.5 s from both ends of every stroke. Ink in
// these steps is an error.
std::vector<bool> pen_must_be_up(const RunData& run, const InkMatch& drawn);

}  // namespace impedraw

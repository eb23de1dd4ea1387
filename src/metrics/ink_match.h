// Matches a run's ink to its target, step by step. Metrics and pictures are based on the result.
#pragma once

#include <algorithm>
#include <set>
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

inline InkMatch match_ink(const RunData& run) {
  const std::size_t n = run.rows();
  InkMatch d;
  d.lines = ink_lines(run.f, run.stroke);
  d.spans = stroke_spans(run.time, run.f, run.stroke);

  std::set<int> strokes(run.target_stroke.begin(), run.target_stroke.end());
  for (const StrokeSpan& span : d.spans) strokes.insert(span.stroke);
  d.strokes.assign(strokes.begin(), strokes.end());
  d.targets.resize(d.strokes.size());
  const auto place = [&d](int stroke) {
    return std::lower_bound(d.strokes.begin(), d.strokes.end(), stroke) - d.strokes.begin();
  };
  for (std::size_t i = 0; i < run.target_points.size(); ++i)
    d.targets[place(run.target_stroke[i])].push_back(run.target_points[i]);

  d.error.assign(n, LogRow::kNone);
  std::vector<std::vector<const InkLine*>> lines_of(d.strokes.size());
  for (const InkLine& line : d.lines) {
    if (line.stroke >= 0) lines_of[place(line.stroke)].push_back(&line);
  }
  for (std::size_t s = 0; s < d.strokes.size(); ++s) {
    if (lines_of[s].empty()) continue;
    const Segments target(std::span(&d.targets[s], 1), kSampleSpacing);
    if (target.empty()) continue;
    for (const InkLine* line : lines_of[s]) {
      for (std::size_t i = line->begin; i < line->end; ++i)
        d.error[i] = target.distance(run.contact_point[i]);
    }
  }
  return d;
}

// True where /stroke is −1 and the time is more than 0.5 s from both ends of every stroke. Ink in
// these steps is an error.
inline std::vector<bool> pen_must_be_up(const RunData& run, const InkMatch& drawn) {
  constexpr double kAllowed = 0.5 + 1e-9;  // [s]
  std::vector<bool> up(run.rows());
  std::vector<double> ends;  // ascending
  for (const StrokeSpan& span : drawn.spans) {
    ends.push_back(run.time[span.begin]);
    ends.push_back(run.time[std::min(span.end, run.rows() - 1)]);
  }
  for (std::size_t i = 0; i < run.rows(); ++i) {
    const auto next = std::lower_bound(ends.begin(), ends.end(), run.time[i]);
    const bool near_next = next != ends.end() && *next - run.time[i] <= kAllowed;
    const bool near = near_next || (next != ends.begin() && run.time[i] - *(next - 1) <= kAllowed);
    up[i] = run.stroke[i] < 0 && !near;
  }
  return up;
}

}  // namespace impedraw

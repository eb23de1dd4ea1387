// A run's ink against its target, row by row: what the metrics average and the pictures show.
#pragma once

#include <vector>

#include "ink/ink_lines.h"
#include "ink/segments.h"
#include "report/run_data.h"

namespace impedraw {

struct Drawn {
  std::vector<double> f;              // n; contact force · outward normal [N], 0 out of contact
  std::vector<InkLine> lines;         // ink, cut where it ends and where /stroke changes
  std::vector<StrokeSpan> spans;      // the plan's strokes, in order of time
  std::vector<int> strokes;           // every stroke that target or plan know of, ascending
  std::vector<std::vector<Eigen::Vector3d>> targets;  // the target polyline of each of `strokes`; empty where it has none
  std::vector<double> error;          // n; distance of the contact point to the target of its own stroke [m]; NaN but on pen-down ink
  std::vector<double> tilt;           // n; angle between −z_E and the canvas's normal [rad]; NaN but on pen-down ink
  std::vector<double> normal_error;   // n; angle between the controller's normal and the canvas's [rad]; NaN too without an estimate

  bool pen_down_ink(const RunData& run, std::size_t i) const { return run.stroke[i] >= 0 && is_ink(f[i]); }
};

Drawn match_ink(const RunData& run);

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b);  // [rad], exact near 0 and π

// True where /stroke is −1 and the row's time is more than 0.5 s from both ends of every stroke: ink here is a fault.
std::vector<bool> pen_must_be_up(const RunData& run, const Drawn& drawn);

}  // namespace impedraw

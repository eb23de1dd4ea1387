// Forces along lines that remove evenly (Preston): the dose of a place is ∫ f ds over the way on
// which the footprint lies on it, since ∫ p v dt does not depend on the feed.
//
//   d_v = Σ_k w_k f_k p_kv over the knots k whose footprint holds v
//   f_k ← f_k · mean over the places under k of (t_v / d_v), in its range, smoothed along the line
//
// w_k: way at k, p_kv: pressure at v over its mean under the footprint, t_v: the dose that is
// wanted. Where that is the same everywhere, it is the mean of d for forces of 1, and at the end
// all are scaled so that their mean over the way is 1. It is the usual way to find dwell times in
// polishing by a small tool.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/cover/pressed_foot.h"

namespace impedraw {

using PlaneLines = std::vector<std::vector<Eigen::Vector2d>>;

// Dose over force, of each vertex [m]; `forces` as in even_forces(), empty: 1.
std::vector<double> dose_of(const SurfaceGrid& grid, const PlaneLines& lines,
                            const PressedFeet& feet,
                            const std::vector<std::vector<double>>& forces = {});

// Mean of a field over the area of these vertices; 0 without any.
double mean_of(const SurfaceGrid& grid, const std::vector<double>& field,
               const std::vector<char>& places);

struct WantedDose {
  std::vector<char> places;        // of the vertices that count
  std::vector<double> share = {};  // of `whole`, for each vertex, > 0; empty: the same everywhere
  double whole = 0.0;              // dose over force [m]
};
struct ForceRange {
  double least, most;  // over the force asked for
};

// Over the force asked for, of each point of the lines.
std::vector<std::vector<double>> even_forces(const SurfaceGrid& grid, const PlaneLines& lines,
                                             const PressedFeet& feet, const WantedDose& wanted,
                                             const ForceRange& range);

// The lines, and those parts of them again, up to `passes` times, that the forces in `range` need
// for a dose above one pass's. All lines of a pass come before the next one's.
PlaneLines in_passes(const SurfaceGrid& grid, const PlaneLines& lines, const PressedFeet& feet,
                     const WantedDose& wanted, const ForceRange& range, int passes);

}  // namespace impedraw

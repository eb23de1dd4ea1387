// Forces along lines that remove evenly (Preston): the dose of a place is ∫ f ds over the way on
// which the footprint lies on it, since ∫ p v dt does not depend on the feed.
//
//   d_v = Σ_k w_k f_k p_kv over the knots k whose footprint holds v
//   f_k ← f_k · mean over the places under k of (d̄ / d_v), within 1 ± most, smoothed along the line
//
// w_k: way at k, p_kv: pressure at v over its mean under the footprint, d̄: mean dose. At the end
// all are scaled so that their mean over the way is 1. It is the usual way to find dwell times in
// polishing by a small tool.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/cover/cover_lines.h"

namespace impedraw {

using PlaneLines = std::vector<std::vector<Eigen::Vector2d>>;

// Dose over force, of each vertex [m]; `forces` as in even_forces(), empty: 1.
std::vector<double> dose_of(const SurfaceGrid& grid, const PlaneLines& lines,
                            const PressedFeet& feet,
                            const std::vector<std::vector<double>>& forces = {});

// Over the force asked for, of each point of the lines. `places`: whose dose is to be even.
std::vector<std::vector<double>> even_forces(const SurfaceGrid& grid, const PlaneLines& lines,
                                             const PressedFeet& feet,
                                             const std::vector<char>& places, double most);

}  // namespace impedraw

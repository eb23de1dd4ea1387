// Automatic placement: moves canvas and drawing together, level, to the pose that maximises the
// smallest margin over the drawing's points.
//
//   margin of a posture   min( least over the joints of (distance to its nearest limit) / (half its
//                         range),  4 σ_min / σ_max )
//
// σ: singular values of the tip's Jacobian, with its angular rows multiplied by 0.3 m. σ_min/σ_max
// is small near singular postures, stretched out or folded. The margin of a pose is the least over
// the drawing's points, with the pen along the canvas's normal; inverse kinematics starts each
// posture from the previous one. A point out of reach counts as minus the remaining error [m]. A
// grid search over (x, y, turn) is followed by a pattern search from its best poses. The best pose
// that passes the whole pre-flight is chosen. Where none does, canvas and default arm.start are
// tried farther from the base, up to 4.5 times, with the default fence: for a large arm.
#pragma once

#include <functional>

#include "impedraw/experiment/scenario.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

struct PlacedCanvas {
  // Canvas, drawing, cameras, region, arm.start and fence are moved; the rest is as given.
  Scenario scenario;
  double turn_deg = 0.0;  // about the drawing's centre
  double margin = 0.0, margin_before = 0.0;
  // Passes the pre-flight. If no pose does, the result is the one with the least undrawable length.
  bool passes = false;
};

// Rotates canvas, its motion and marks, drawing, cameras and camera targets by turn_deg about the
// vertical through the drawing's centre, then translates them. The perception region keeps its size
// and its centre moves. Jolts stay along the axes of W, and a recorded motion stays as it is.
Scenario moved(const Scenario& scenario, const Eigen::Vector2d& move, double turn_deg);

// `progress`: fraction done, 0 to 1. Throws InputError like prepare(), for a tilted drawing plane
// and for a recorded motion.
PlacedCanvas place_automatically(const Scenario& scenario, const Places& places,
                                 const std::function<void(double)>& progress = {});

}  // namespace impedraw

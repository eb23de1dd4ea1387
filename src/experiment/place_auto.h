// Where canvas and drawing ought to stand before the arm: moved together, level, to the pose in
// which the worst point of the drawing is best.
//
//   margin of a posture   min( least over the joints of (distance to its nearest limit) / (half its
//                         range),  4 σ_min / σ_max )
//
// σ: singular values of the tip's Jacobian, its angular rows times 0.3 m: small where the arm is
// stretched out or folded into a singular posture. Margin of a pose: the least over the drawing's
// points, the pen along the canvas's normal, each posture from the last. A point out of reach
// counts as minus how far the tip stays off [m]. A grid over (x, y, turn) first, then a pattern
// search about the best of it; of the best, the first that passes the whole pre-flight is taken.
#pragma once

#include <functional>

#include "impedraw/experiment/scenario.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

struct PlacedCanvas {
  Scenario scenario;  // with canvas, drawing, cameras and region moved; all else as given
  Eigen::Vector2d move = Eigen::Vector2d::Zero();  // of the drawing's centre [m]
  double turn_deg = 0.0;                           // about it
  double margin = 0.0, margin_before = 0.0;
  // the pre-flight; where no pose does, the one with the least that cannot be drawn
  bool passes = false;
};

// Turned by turn_deg about the vertical through the drawing's centre, then moved: canvas, drawing,
// cameras with what they look at, and the region that they keep (as large, about its moved middle).
Scenario moved(const Scenario& scenario, const Eigen::Vector2d& move, double turn_deg);

// `progress`: share done, 0 to 1. InputError: as prepare() throws; a tilted drawing plane, which is
// not moved.
PlacedCanvas place_automatically(const Scenario& scenario, const Places& places,
                                 const std::function<void(double)>& progress = {});

}  // namespace impedraw

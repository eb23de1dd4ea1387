// The order and direction in which strokes are drawn, so that the pen travels little in the air.
//
// Travel is the sum of the straight ways from where a stroke ends to where the next one begins, on
// the page. A tour is made of the shortest links between ends first (greedy matching), then
// improved by 2-opt (a run of strokes is turned round) and Or-opt (up to three strokes move
// elsewhere, either way round) over each end's nearest neighbours, then shaken: a few neighbouring
// runs change places, what follows is improved again, and taken back where that was longer. Every
// run of it does the same: the random numbers have a fixed seed.
//
// Layers are pens: they stay in their order, one after the other, unless told otherwise.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

struct OrderSettings {
  bool keep_layers = true;
  int shakes = 10;  // for each stroke, up to 100,000 in all; 0 leaves out the shaking
};

struct Visit {
  int stroke = 0;  // index into the strokes that came in
  bool backwards = false;
};

// Each stroke once. Strokes need at least one point, consecutive ones in a stroke may be equal.
std::vector<Visit> shortest_order(const std::vector<Stroke>& strokes,
                                  const OrderSettings& settings = {});

// The same strokes in that order, turned round where it says so.
std::vector<Stroke> in_order(const std::vector<Stroke>& strokes, const std::vector<Visit>& order);

double pen_up_length(const std::vector<Stroke>& strokes);    // in the order they have [mm]
double pen_down_length(const std::vector<Stroke>& strokes);  // [mm]

}  // namespace impedraw

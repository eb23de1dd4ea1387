// Orders and orients strokes to shorten pen-up travel.
//
// Travel is the sum of the straight lines from each stroke's end to the next one's start, on the
// page. Greedy matching first builds a tour from the shortest links between ends. Then 2-opt
// (reverse a run of strokes) and Or-opt (move up to three strokes, either way round) improve it
// over each end's nearest neighbours. Then it is shaken: a few neighbouring runs swap places, the
// result is improved again, and kept unless it is longer. The random seed is fixed, so the result
// is reproducible.
//
// Layers are pens. They keep their order unless OrderSettings::keep_layers is false.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

struct OrderSettings {
  bool keep_layers = true;
  int shakes = 10;  // per stroke, up to 100,000 in all; 0: no shaking
};

struct Visit {
  int stroke = 0;  // index into the input
  bool backwards = false;
};

// Visits each stroke once. A stroke needs at least one point; consecutive points may be equal.
// `progress`, if given, gets the share done now and then.
std::vector<Visit> shortest_order(const std::vector<Stroke>& strokes,
                                  const OrderSettings& settings = {},
                                  const std::function<void(double)>& progress = {});

void reverse(Stroke& stroke);  // draws it from its end to its start

// The strokes in that order, reversed where `backwards` is set.
std::vector<Stroke> in_order(const std::vector<Stroke>& strokes, const std::vector<Visit>& order);

double pen_up_length(const std::vector<Stroke>& strokes);    // in the given order [mm]
double pen_down_length(const std::vector<Stroke>& strokes);  // [mm]

}  // namespace impedraw

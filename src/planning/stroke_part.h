// Parts of strokes: rejected by a check, still to draw, or left without ink.
#pragma once

#include <vector>

#include "impedraw/drawing/placement.h"

namespace impedraw {

// The interval [from, to] of a stroke, measured from its first point along its line in the drawing
// plane [m]. A dot is [0, 0].
struct StrokePart {
  int stroke = 0;  // PlacedStroke::number
  double from = 0, to = 0;

  double length() const { return to - from; }
};

double plane_length(const PlacedStroke& stroke);                // [m]
double plane_length(const std::vector<PlacedStroke>& strokes);  // of all of them [m]

// Returns the part of the stroke within [from, to], measured as in StrokePart. The stroke may be a
// part that starts later. The interval is clipped to the stroke and its ends are interpolated. If
// only a point remains, the result is a dot.
PlacedStroke part_of(const PlacedStroke& stroke, double from, double to);

// The stroke's point at `along`, its page point and the force there. `along` is clamped to it.
struct StrokePlace {
  Eigen::Vector2d p_P;   // in the drawing plane [m]
  Eigen::Vector2d page;  // [mm]
  double force = 0.0;    // [N]; 0 where the stroke has none
};
StrokePlace place_on(const PlacedStroke& stroke, double along);

// The stroke's position nearest to p_P, measured as in StrokePart [m].
double nearest_place(const PlacedStroke& stroke, const Eigen::Vector2d& p_P);

// Sorts the parts and merges those of the same stroke that touch, overlap or lie within `gap` of
// each other.
std::vector<StrokePart> merged(std::vector<StrokePart> parts, double gap = 0);

// Returns the parts of [0, length of each stroke] that `parts` do not cover, in the strokes' order.
// Pieces of at most `shortest` are dropped, unless no part touches their stroke. The strokes must
// be whole.
std::vector<StrokePart> rest_of(const std::vector<PlacedStroke>& strokes,
                                const std::vector<StrokePart>& parts, double shortest = 0);

}  // namespace impedraw

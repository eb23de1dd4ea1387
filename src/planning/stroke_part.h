// Parts of strokes: what a check refuses, what is left to draw, what got no ink.
#pragma once

#include <vector>

#include "impedraw/drawing/placement.h"

namespace impedraw {

// The stretch [from, to] of a stroke, measured along its line in the drawing plane from its first
// point [m]. A dot is [0, 0].
struct StrokePart {
  int stroke = 0;  // PlacedStroke::number
  double from = 0, to = 0;

  double length() const { return to - from; }
};

double plane_length(const PlacedStroke& stroke);  // [m]

// What of the stroke lies within [from, to], measured as in StrokePart (so the stroke may itself be
// a part that starts later); its ends are interpolated. Outside of the stroke it is cut off; where
// nothing but a point is left, a dot.
PlacedStroke part_of(const PlacedStroke& stroke, double from, double to);

// Point of the stroke at that place, and its page point; held at its ends.
struct StrokePlace {
  Eigen::Vector2d p_P;   // in the drawing plane [m]
  Eigen::Vector2d page;  // [mm]
};
StrokePlace place_on(const PlacedStroke& stroke, double along);

// The place on the stroke that is nearest to p_P, measured as in StrokePart [m].
double nearest_place(const PlacedStroke& stroke, const Eigen::Vector2d& p_P);

// In order, those of one stroke that touch or overlap, or lie within `gap` of one another, made
// one.
std::vector<StrokePart> merged(std::vector<StrokePart> parts, double gap = 0);

// Of [0, length of each stroke], what `parts` do not cover, in the strokes' order; pieces of at
// most `shortest` are left out, but not a stroke that none of the parts touches. The strokes are
// whole ones.
std::vector<StrokePart> rest_of(const std::vector<PlacedStroke>& strokes,
                                const std::vector<StrokePart>& parts, double shortest = 0);

}  // namespace impedraw

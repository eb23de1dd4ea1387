// Places and parts of one stroke, for many look-ups.
#pragma once

#include <vector>

#include "impedraw/planning/stroke_part.h"

namespace impedraw {

// place_on() and part_of() for many look-ups on one stroke: each takes the logarithm of the
// stroke's points instead of all of them. Refers to the stroke.
class StrokeRuler {
 public:
  explicit StrokeRuler(const PlacedStroke& stroke);

  const PlacedStroke& stroke() const { return stroke_; }
  double length() const { return length_; }  // [m]
  StrokePlace at(double along) const;
  PlacedStroke part(double from, double to) const;

 private:
  const PlacedStroke& stroke_;
  std::vector<double> along_;  // of each point
  double length_;
};

}  // namespace impedraw

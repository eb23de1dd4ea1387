// The force of the pen along a stroke, as a smooth function of the place on it.
//
// Between the stroke's points the force changes evenly. On a grid of kStep this is F_i, limited to
//   F_i ≤ F_k + steepest |s_i − s_k|   for all k,
// the largest such function below it: a jump is spread to the heavier side, so that the line is
// nowhere heavier than asked. F(s) is the cubic B-spline with these coefficients: C², within the
// range of F_i, off a kink by a sixth of what the slope changes over a step.
#pragma once

#include <vector>

#include "impedraw/drawing/placement.h"

namespace impedraw {

struct ForceSample {
  double force = 0.0;  // [N]; 0: none of its own
  double slope = 0.0;  // dF/ds [N/m]
  double depth = 0.0;  // of the stroke [m]
};

class ForceProfile {
 public:
  static constexpr double kStep = 5e-4;  // [m]

  ForceProfile() = default;  // none
  // None if the stroke has no forces. steepest [N/m], > 0.
  ForceProfile(const PlacedStroke& stroke, double steepest);

  bool empty() const noexcept { return force_.empty(); }
  // s: measured as in stroke_part.h, clamped to the stroke [m]. Allocates nothing.
  ForceSample at(double s) const noexcept;
  // Length along which the force stays below what was asked by more than `less` [m, N].
  double spread_length(double less) const noexcept;

 private:
  double from_ = 0.0, step_ = kStep, depth_ = 0.0;
  std::vector<double> force_;     // coefficients [N]: those of the ends stand twice
  std::vector<double> withheld_;  // asked less force, at each [N]
};

}  // namespace impedraw

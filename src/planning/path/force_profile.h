// The force of the pen along a stroke, as a smooth function of the place on it.
//
// Between the stroke's points the force changes evenly. On a grid of kStep this is F_i, limited to
//   F_i ≤ F_k + steepest |s_i − s_k|   for all k,
// the largest such function below it: a jump is spread to the heavier side, so that the line is
// nowhere heavier than asked. F(s) is the cubic B-spline with these coefficients: C², within the
// range of F_i, off a kink by a sixth of what the slope changes over a step.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "impedraw/drawing/placement.h"
#include "impedraw/planning/stroke_ruler.h"

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
  ForceProfile(const PlacedStroke& stroke, double steepest) {
    if (stroke.force.empty()) return;
    depth_ = stroke.depth;
    const StrokeRuler ruler(stroke);
    const auto steps =
        std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(ruler.length() / kStep)));
    from_ = stroke.start;
    step_ = std::max(ruler.length() / static_cast<double>(steps), 1e-9);
    std::vector<double> asked(steps + 1);
    for (std::size_t i = 0; i <= steps; ++i)
      asked[i] = ruler.at(from_ + static_cast<double>(i) * step_).force;
    if (std::ranges::all_of(asked, [&](double f) { return f == asked[0]; })) asked = {asked[0]};
    std::vector<double> limited = asked;
    for (std::size_t i = 1; i < limited.size(); ++i)
      limited[i] = std::min(limited[i], limited[i - 1] + steepest * step_);
    for (std::size_t i = limited.size() - 1; i-- > 0;)
      limited[i] = std::min(limited[i], limited[i + 1] + steepest * step_);
    for (std::size_t i = 0; i < limited.size(); ++i) withheld_.push_back(asked[i] - limited[i]);
    force_ = {limited.front()};
    force_.insert(force_.end(), limited.begin(), limited.end());
    force_.push_back(limited.back());
  }

  bool empty() const noexcept { return force_.empty(); }
  // s: measured as in stroke_part.h, clamped to the stroke [m]. Allocates nothing.
  ForceSample at(double s) const noexcept {
    if (force_.empty()) return {};
    if (force_.size() == 3) return {force_[0], 0.0, depth_};
    const double u = std::clamp((s - from_) / step_, 0.0, static_cast<double>(force_.size() - 3));
    const auto i = std::min(static_cast<std::size_t>(u), force_.size() - 4);
    const double t = u - static_cast<double>(i), r = 1.0 - t;
    const double* c = &force_[i];
    return {(r * r * r * c[0] + (3.0 * t * t * t - 6.0 * t * t + 4.0) * c[1] +
             (3.0 * r * r * r - 6.0 * r * r + 4.0) * c[2] + t * t * t * c[3]) /
                6.0,
            (-r * r * c[0] + (3.0 * t * t - 4.0 * t) * c[1] - (3.0 * r * r - 4.0 * r) * c[2] +
             t * t * c[3]) /
                (2.0 * step_),
            depth_};
  }
  // Length along which the force stays below what was asked by more than `less` [m, N].
  double spread_length(double less) const noexcept {
    return step_ * static_cast<double>(
                       std::ranges::count_if(withheld_, [&](double w) { return w > less; }));
  }

 private:
  double from_ = 0.0, step_ = kStep, depth_ = 0.0;
  std::vector<double> force_;     // coefficients [N]: those of the ends stand twice
  std::vector<double> withheld_;  // asked less force, at each [N]
};

}  // namespace impedraw

// The width of a pen's line, by its force.
//
//   w(f) = width + width_per_newton (f − nominal_force), limited to 0.25 … 3 times `width`
#pragma once

#include <algorithm>

namespace impedraw {

struct PenSettings {
  double width = 1.0;             // at the nominal force [mm]
  double width_per_newton = 0.0;  // [mm/N]; 0: constant width
  double nominal_force = 5.0;     // [N]
  // With which lines are drawn whose width or force is given.
  double least_force = 1.0, most_force = 8.0;  // [N]

  bool presses() const { return width_per_newton != 0.0; }
  double width_at(double force) const {  // [mm]
    return std::clamp(width + width_per_newton * (force - nominal_force), 0.25 * width,
                      3.0 * width);
  }
  // The force for a line of that width [mm], within the pen's limits. Only if it presses().
  double force_for(double wanted) const {
    const double w = std::clamp(wanted, 0.25 * width, 3.0 * width);
    return within(nominal_force + (w - width) / width_per_newton);
  }
  double thinnest() const {  // [mm]
    return presses() ? std::min(width_at(least_force), width_at(most_force)) : width;
  }
  double within(double force) const { return std::clamp(force, least_force, most_force); }
};

}  // namespace impedraw

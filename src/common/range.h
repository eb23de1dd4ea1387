// Valid range of a setting. Each limit is defined once, as a Range in the struct of the setting.
// The library's checks and the scenario schema both use it.
#pragma once

#include <limits>

namespace impedraw {

// A closed interval, unless `above` or `below` is set.
struct Range {
  double lowest;
  double highest;
  bool above = false;  // excludes lowest
  bool below = false;  // excludes highest

  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static constexpr Range any() { return {-infinity, infinity}; }
  static constexpr Range at_least(double lowest) { return {lowest, infinity}; }
  static constexpr Range at_most(double highest) { return {-infinity, highest}; }
  static constexpr Range positive() { return {0, infinity, true}; }
  static constexpr Range positive_to(double highest) { return {0, highest, true}; }
  static constexpr Range to_below(double lowest, double highest) {
    return {lowest, highest, false, true};
  }

  constexpr bool holds(double x) const {
    return (above ? x > lowest : x >= lowest) && (below ? x < highest : x <= highest);
  }
};

}  // namespace impedraw

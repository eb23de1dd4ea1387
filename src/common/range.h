// The values that a setting may have. A limit stands once, as a Range in the struct that has the
// setting: the library's own check and a scenario's schema both read it.
#pragma once

#include <limits>

namespace impedraw {

// Closed at both ends, unless it says otherwise.
struct Range {
  double lowest;
  double highest;
  bool above = false;  // lowest itself is not allowed
  bool below = false;  // highest itself is not allowed

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

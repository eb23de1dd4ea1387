// Valid range of a setting. A group of settings is described by describe(f, settings), which
// RangeChecks (range_check.h) and the scenario's reader (settings/schema.h) both read, so that a
// range, its unit and its name are written once. A struct with one or two numbers may have a Limit
// for each in a nested struct Limits instead.
#pragma once

#include <limits>
#include <string_view>

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

// A number of a settings struct. For a vector, the range is that of each component.
struct Limit {
  std::string_view name;  // as in a scenario file
  std::string_view unit;  // empty: none
  Range range;
};

}  // namespace impedraw

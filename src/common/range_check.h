// Checks settings against their ranges. Messages have the wording of the scenario schema.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "impedraw/common/errors.h"
#include "impedraw/common/range.h"

namespace impedraw {

// Shortest text that parses to exactly the same number.
inline std::string shortest_text(double x) {
  std::array<char, 40> buffer;
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), x);
  return {buffer.data(), end};
}

inline std::string with_unit(std::string text, std::string_view unit) {
  if (!unit.empty()) text.append(" ").append(unit);
  return text;
}

// "0 to 50 N", "more than 0 s", "at least 1"; empty if every finite number is allowed.
inline std::string range_text(const Range& range, std::string_view unit) {
  const bool from = std::isfinite(range.lowest), to = std::isfinite(range.highest);
  const std::string lowest = shortest_text(range.lowest), highest = shortest_text(range.highest);
  const std::string low = range.above ? "more than " : "at least ";
  const std::string high = range.below ? "less than " : "at most ";
  if (!from && !to) return {};
  if (from && to && !range.above && !range.below) return with_unit(lowest + " to " + highest, unit);
  std::string text = from ? low + lowest : "";
  if (from && to) text += " and ";
  if (to) text += high + highest;
  return with_unit(text, unit);
}

// Throws InputError if the value is out of range or not finite, with a message such as
// "path.draw_speed is 7 m/s, allowed is 1e-04 to 1 m/s".
inline void require_in_range(std::string_view name, double value, const Range& range,
                             std::string_view unit) {
  if (std::isfinite(value) && range.holds(value)) return;
  const std::string allowed = range_text(range, unit);
  throw InputError(std::string(name) + " is " + with_unit(shortest_text(value), unit) +
                   ", allowed is " + (allowed.empty() ? "any finite number" : allowed));
}

// The same for a setting, which the message names "group.name".
inline void require_in_range(std::string_view group, const Limit& limit, double value) {
  if (std::isfinite(value) && limit.range.holds(value)) return;
  require_in_range(std::string(group) + "." + std::string(limit.name), value, limit.range,
                   limit.unit);
}

// The same for each component of a vector.
template <class Vector>
requires requires(const Vector& x) { x.begin(); }
inline void require_in_range(std::string_view group, const Limit& limit, const Vector& values) {
  for (const double value : values) require_in_range(group, limit, value);
}

// Reads a description of settings, describe(f, settings), and throws InputError for the first
// number out of its range, as require_in_range does. It ignores what else a description says. The
// same description read by a Fields (settings/schema.h) gives YAML, schema and documentation.
class RangeChecks {
 public:
  explicit RangeChecks(std::string group) : group_(std::move(group)) {}

  // A number, a vector of numbers, or an optional one.
  template <class T>
  RangeChecks& field(std::string_view name, const T& value, const Range& range,
                     std::string_view unit, std::string_view = {}) {
    if constexpr (requires { value.has_value(); }) {
      if (value) field(name, *value, range, unit);
    } else if constexpr (requires { value.begin(); }) {
      for (const double x : value) field(name, x, range, unit);
    } else {
      require_in_range(group_, {name, unit, range}, static_cast<double>(value));
    }
    return *this;
  }
  // A number that only the library's own callers set.
  template <class T>
  RangeChecks& constant(std::string_view name, const T& value, const Range& range,
                        std::string_view unit) {
    return field(name, value, range, unit);
  }
  // A group with a description of its own, a switch or a text.
  template <class T>
  RangeChecks& field(std::string_view name, T& part, std::string_view) {
    if constexpr (requires(RangeChecks & f) { describe(f, part); }) {
      RangeChecks within(group_ + "." + std::string(name));
      describe(within, part);
    }
    return *this;
  }
  template <class E>
  RangeChecks& choice(std::string_view, const E&, std::initializer_list<std::string_view>,
                      std::string_view) {
    return *this;
  }
  RangeChecks& formerly(std::string_view, std::string_view = {}) { return *this; }
  RangeChecks& for_users() { return *this; }
  RangeChecks& or_one() { return *this; }

 private:
  std::string group_;
};

// Checks all numbers that the settings' description has; the messages name them "group.name".
template <class T>
void require_ranges(std::string group, const T& settings) {
  RangeChecks checks(std::move(group));
  describe(checks, const_cast<T&>(settings));  // which only reads them
}

}  // namespace impedraw

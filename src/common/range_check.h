// Checks settings against their ranges. Messages have the wording of the scenario schema.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

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

}  // namespace impedraw

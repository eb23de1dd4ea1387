// Converts settings to and from text, and words the errors about them.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "impedraw/common/range.h"
#include "impedraw/common/range_check.h"

namespace impedraw {

// Shortest text that reads back as exactly the same number.
std::string number_text(double x);
std::string number_text(std::int64_t x);
std::string number_text(std::uint64_t x);
template <class T>
requires std::is_integral_v<T> std::string number_text(T x) {
  return number_text(
      static_cast<std::conditional_t<std::is_signed_v<T>, std::int64_t, std::uint64_t>>(x));
}

// Stores the text's number, or leaves `value` unchanged and returns the fault, worded to follow the
// setting's name: "is 70 N, allowed is 0 to 50 N".
std::optional<std::string> parse_number(std::string_view text, const Range& range,
                                        std::string_view unit, double& value);
std::optional<std::string> parse_number(std::string_view text, const Range& range,
                                        std::string_view unit, std::int64_t& value);
std::optional<std::string> parse_number(std::string_view text, const Range& range,
                                        std::string_view unit, std::uint64_t& value);
template <class T>
requires std::is_integral_v<T> std::optional<std::string> parse_number(std::string_view text,
                                                                       const Range& range,
                                                                       std::string_view unit,
                                                                       T& value) {
  std::conditional_t<std::is_signed_v<T>, std::int64_t, std::uint64_t> wide{};
  constexpr auto least = static_cast<double>(std::numeric_limits<T>::min());
  constexpr auto most = static_cast<double>(std::numeric_limits<T>::max());
  Range fits = range;  // narrowed to what T can hold
  if (fits.lowest < least) fits.lowest = least, fits.above = false;
  if (fits.highest > most) fits.highest = most, fits.below = false;
  if (auto wrong = parse_number(text, fits, unit, wide)) return wrong;
  value = static_cast<T>(wide);
  return std::nullopt;
}

// Optimal string alignment distance: the least number of letters to insert, delete, replace or swap
// with a neighbour to turn a into b.
int edit_distance(std::string_view a, std::string_view b);

// The valid word closest to `word`; nullopt if none is close enough.
std::optional<std::string> nearest_word(std::string_view word,
                                        const std::vector<std::string>& valid);

// "is 'treu'; did you mean 'true'? Valid: none, true" (always lists the valid words, since a choice
// has few)
std::string not_among(std::string_view word, const std::vector<std::string>& valid);

// The text on one line, shortened to 60 characters, for an error message.
std::string shown(std::string_view text);

std::string joined(const std::vector<std::string>& words);  // "a, b, c"

// As YAML, quoted only if necessary.
std::string yaml_string(std::string_view text);

}  // namespace impedraw

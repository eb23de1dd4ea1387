// Settings as text: numbers, limits, and the words of errors about them.
#pragma once

#include <charconv>
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

// Shortest text that reads back as the very same number.
std::string number_text(double x);
std::string number_text(std::int64_t x);
std::string number_text(std::uint64_t x);
template <class T>
requires std::is_integral_v<T> std::string number_text(T x) {
  return number_text(
      static_cast<std::conditional_t<std::is_signed_v<T>, std::int64_t, std::uint64_t>>(x));
}

// Stores the text's number, or leaves value alone and returns what is wrong with it, to stand after
// the setting's name: "is 70 N, allowed is 0 to 50 N".
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

// Smallest number of letters to insert, delete, replace or swap with a neighbour (optimal string
// alignment) that makes a into b.
int edit_distance(std::string_view a, std::string_view b);

// The valid word that `word` was most likely meant to be; none when all are too far off.
std::optional<std::string> nearest_word(std::string_view word,
                                        const std::vector<std::string>& valid);

// "is 'treu'; did you mean 'true'? Valid: none, true" (valid words always, as a choice has few)
std::string not_among(std::string_view word, const std::vector<std::string>& valid);

// The text on one line and of at most 60 characters, to be shown in an error.
std::string shown(std::string_view text);

std::string joined(const std::vector<std::string>& words);  // "a, b, c"

// As YAML, quoted only where that is needed.
std::string yaml_string(std::string_view text);

}  // namespace impedraw

#include "impedraw/settings/settings_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>

namespace impedraw {

namespace {

std::string outside(const std::string& number, const Range& range, std::string_view unit) {
  return fmt::format("is {}, allowed is {}", with_unit(number, unit), range_text(range, unit));
}

// std::from_chars does not accept a leading plus.
std::string_view without_plus(std::string_view text) {
  return text.size() > 1 && text[0] == '+' && text[1] != '-' ? text.substr(1) : text;
}

template <class T>
std::string shortest(T x) {
  std::array<char, 40> buffer;
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), x);
  return {buffer.data(), end};
}

template <class T>
std::optional<std::string> parse_integer(std::string_view text, const Range& range,
                                         std::string_view unit, T& value) {
  const std::string_view digits = without_plus(text);
  T parsed{};
  // 1e9 and 3.0 are whole numbers, too; a double holds those up to 2^53.
  if (double real; digits.find_first_of(".eE") != std::string_view::npos &&
                   !parse_number(text, Range::any(), "", real) && real == std::floor(real)) {
    constexpr double kExact = 9007199254740992.0;
    if (std::abs(real) > kExact || real < static_cast<double>(std::numeric_limits<T>::min()) ||
        !range.holds(real))
      return outside(shown(text), range, unit);
    value = static_cast<T>(real);
    return std::nullopt;
  }
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), parsed);
  if (error == std::errc::result_out_of_range) return outside(shown(text), range, unit);
  if (error != std::errc() || end != digits.data() + digits.size()) {
    if (double other; !parse_number(text, Range::any(), "", other) && other < 0 &&
                      std::is_unsigned_v<T> && other == std::floor(other))
      return outside(shown(text), range, unit);
    return fmt::format("is '{}', which is not a whole number", shown(text));
  }
  if (!range.holds(static_cast<double>(parsed))) return outside(shortest(parsed), range, unit);
  value = parsed;
  return std::nullopt;
}

// YAML, or an optional setting, does not read these words as text.
bool has_another_meaning(std::string_view text) {
  return text == "null" || text == "Null" || text == "NULL" || text == "true" || text == "false";
}

}  // namespace

std::string number_text(double x) { return shortest(x); }
std::string number_text(std::int64_t x) { return shortest(x); }
std::string number_text(std::uint64_t x) { return shortest(x); }

std::optional<std::string> parse_number(std::string_view text, const Range& range,
                                        std::string_view unit, double& value) {
  std::string lower(without_plus(text));
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  for (const char* special :
       {"nan", ".nan", "-nan", "inf", ".inf", "-inf", "-.inf", "infinity", "-infinity"}) {
    if (lower != special) continue;
    const std::string limits = range_text(range, unit);
    return fmt::format("is {}, but must be a finite number{}", shown(text),
                       limits.empty() ? "" : ", " + limits);
  }
  double parsed = 0;
  const auto [end, error] = std::from_chars(lower.data(), lower.data() + lower.size(), parsed);
  if (end != lower.data() + lower.size() || error == std::errc::invalid_argument)
    return fmt::format("is '{}', which is not a number{}", shown(text),
                       unit.empty() ? "" : fmt::format(" (of {})", unit));
  if (error == std::errc::result_out_of_range)
    return fmt::format("is {}, which a double cannot hold", shown(text));
  if (!range.holds(parsed)) return outside(shortest(parsed), range, unit);
  value = parsed;
  return std::nullopt;
}

std::optional<std::string> parse_number(std::string_view text, const Range& range,
                                        std::string_view unit, std::int64_t& value) {
  return parse_integer(text, range, unit, value);
}

std::optional<std::string> parse_number(std::string_view text, const Range& range,
                                        std::string_view unit, std::uint64_t& value) {
  return parse_integer(text, range, unit, value);
}

int edit_distance(std::string_view a, std::string_view b) {
  // row[i][j]: distance of a's first i letters to b's first j; a swap looks back two rows.
  std::vector<std::vector<int>> row(a.size() + 1, std::vector<int>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        row[i][j] = static_cast<int>(i + j);
        continue;
      }
      const int replaced = row[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
      row[i][j] = std::min({row[i - 1][j] + 1, row[i][j - 1] + 1, replaced});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        row[i][j] = std::min(row[i][j], row[i - 2][j - 2] + 1);
    }
  }
  return row[a.size()][b.size()];
}

std::optional<std::string> nearest_word(std::string_view word,
                                        const std::vector<std::string>& valid) {
  std::optional<std::string> nearest;
  int best = 0;
  if (word.size() > 100) return nearest;  // too long for a typing error
  const auto same_letter = [](unsigned char a, unsigned char b) {
    return std::tolower(a) == std::tolower(b);
  };
  for (const std::string& candidate : valid)
    if (std::equal(word.begin(), word.end(), candidate.begin(), candidate.end(), same_letter))
      return candidate;
  for (const std::string& candidate : valid) {
    int distance = edit_distance(word, candidate);
    // A truncated or extended word is as close as a typo: frict for friction, force_n for force.
    const std::string_view shorter =
        word.size() < candidate.size() ? word : std::string_view(candidate);
    const std::string_view longer =
        word.size() < candidate.size() ? std::string_view(candidate) : word;
    if (shorter.size() >= 3 && longer.starts_with(shorter)) distance = std::min(distance, 2);
    const int allowed = std::max<int>(1, std::max(word.size(), candidate.size()) / 3);
    if (distance <= std::max(allowed, shorter.size() >= 3 && longer.starts_with(shorter) ? 2 : 0) &&
        (!nearest || distance < best)) {
      nearest = candidate;
      best = distance;
    }
  }
  return nearest;
}

std::string shown(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string line(text.substr(0, longest));
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  if (text.size() > longest) {
    while (!line.empty() && (static_cast<unsigned char>(line.back()) & 0xc0) == 0x80)
      line.pop_back();  // never split a UTF-8 character
    if (!line.empty() && static_cast<unsigned char>(line.back()) >= 0xc0) line.pop_back();
    line += "…";
  }
  return line;
}

std::string joined(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

std::string not_among(std::string_view word, const std::vector<std::string>& valid) {
  const auto nearest = nearest_word(word, valid);
  return fmt::format(
      "is '{}'; {}{}", shown(word),
      nearest ? fmt::format("did you mean '{}'? Valid: ", *nearest) : "valid: ", joined(valid));
}

std::string yaml_string(std::string_view text) {
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '/' || c == '.' || c == '-';
  };
  const bool starts_well = !text.empty() && (std::isalpha(static_cast<unsigned char>(text[0])) ||
                                             text[0] == '/' || text[0] == '_');
  if (starts_well && std::all_of(text.begin(), text.end(), plain) && !has_another_meaning(text))
    return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      quoted.append("\\").push_back(c);
    else if (c == '\n')
      quoted += "\\n";
    else if (c == '\t')
      quoted += "\\t";
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      quoted += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    else
      quoted += c;
  }
  return quoted + '"';
}

}  // namespace impedraw

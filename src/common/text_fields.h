// The fields of a line of text: numbers that people and spreadsheets write.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <vector>

namespace impedraw {

inline std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

// Separated by commas or semicolons if the line has any, else by blanks.
inline std::vector<std::string_view> fields_of(std::string_view line) {
  const bool separated = line.find_first_of(",;") != std::string_view::npos;
  const char* separators = separated ? ",;" : " \t";
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t end = line.find_first_of(separators);
    const std::string_view field = trimmed(line.substr(0, end));
    if (separated || !field.empty()) fields.push_back(field);
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end + 1);
  }
}

// Absent unless the whole field is a number.
inline std::optional<double> number_in(std::string_view field) {
  if (field.starts_with('+')) field.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size() || field.empty())
    return std::nullopt;
  return value;
}

}  // namespace impedraw

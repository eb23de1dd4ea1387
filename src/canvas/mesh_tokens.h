// Parses words and numbers of mesh files.
#pragma once

#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace impedraw {

// Removes the next word from the front of `text`; empty at its end.
inline std::string_view next_word(std::string_view* text) {
  const auto space = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
  std::size_t from = 0;
  while (from < text->size() && space((*text)[from])) ++from;
  std::size_t to = from;
  while (to < text->size() && !space((*text)[to])) ++to;
  const std::string_view word = text->substr(from, to - from);
  text->remove_prefix(to);
  return word;
}

// Removes the next line from the front of `text`; false at its end. LF, CR LF or CR ends a line.
inline bool next_line(std::string_view* text, std::string_view* line) {
  if (text->empty()) return false;
  const std::size_t end = text->find_first_of("\r\n");
  *line = text->substr(0, end);
  text->remove_prefix(end == text->npos ? text->size() : end);
  text->remove_prefix(text->starts_with("\r\n") ? 2 : text->empty() ? 0 : 1);
  return true;
}

// Parses all of `word` as a number, with an optional "+".
template <class T>
bool whole_number(std::string_view word, T* value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), *value);
  return error == std::errc() && end == word.data() + word.size();
}

inline bool finite_number(std::string_view word, double* value) {
  return whole_number(word, value) && std::isfinite(*value);
}

// Compares ignoring case; `lower` is in lower case.
inline bool same_word(std::string_view word, std::string_view lower) {
  if (word.size() != lower.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    if (std::tolower(static_cast<unsigned char>(word[i])) != lower[i]) return false;
  }
  return true;
}

// Reads the first `size` bytes, at most 4.
inline std::uint32_t unsigned_bytes(std::string_view bytes, int size, bool big_endian) {
  std::uint32_t value = 0;
  for (int i = 0; i < size; ++i)
    value |= std::uint32_t{static_cast<unsigned char>(bytes[i])}
             << 8 * (big_endian ? size - 1 - i : i);
  return value;
}
inline std::uint32_t little_endian_u32(std::string_view bytes) {
  return unsigned_bytes(bytes, 4, false);
}

}  // namespace impedraw

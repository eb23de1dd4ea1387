// Text that others wrote, on its way to a terminal, a page or a log.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

namespace impedraw {

struct Utf8Character {
  std::uint32_t code;
  std::size_t bytes;  // 0: not UTF-8
};

// The first character of a text that is not empty. Overlong forms, surrogates and codes above
// U+10FFFF are not UTF-8.
inline Utf8Character first_character(std::string_view text) {
  constexpr Utf8Character kWrong{0, 0};
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes) return kWrong;
  std::uint32_t code = lead & (0xffu >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return kWrong;
    code = code << 6 | (byte(i) & 0x3f);
  }
  const bool overlong = (bytes == 3 && code < 0x800) || (bytes == 4 && code < 0x10000);
  if (overlong || (code >= 0xd800 && code < 0xe000) || code > 0x10ffff) return kWrong;
  return {code, bytes};
}

inline bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const Utf8Character c = first_character(text);
    if (c.bytes == 0) return false;
    text.remove_prefix(c.bytes);
  }
  return true;
}

// Control characters other than those in `kept` become \u001b and the like, as in JSON, so that
// printed JSON keeps its meaning. So do line separators and the characters that reverse the
// direction of writing. Bytes that are not UTF-8 become U+FFFD.
inline std::string printable(std::string_view text, std::string_view kept = "\n\t") {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const auto [code, bytes] = first_character(text);
    const bool control = code < 0x20 || (code >= 0x7f && code < 0xa0) ||
                         (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
    if (bytes == 0) {
      out += "\uFFFD";
    } else if (control && (bytes > 1 || kept.find(text.front()) == kept.npos)) {
      char escape[8];
      std::snprintf(escape, sizeof escape, "\\u%04x", static_cast<unsigned>(code & 0xffff));
      out += escape;
    } else {
      out += text.substr(0, bytes);
    }
    text.remove_prefix(bytes == 0 ? 1 : bytes);
  }
  return out;
}

// The same without line breaks and tabs.
inline std::string printable_line(std::string_view text) { return printable(text, ""); }

}  // namespace impedraw

#include "impedraw/drawing/hershey.h"

#include <algorithm>
#include <charconv>
#include <fstream>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/files/data_folder.h"

namespace impedraw {

using Eigen::Vector2d;

Eigen::AlignedBox2d Glyph::box() const {
  Eigen::AlignedBox2d box;
  for (const auto& stroke : strokes) {
    for (const Vector2d& p : stroke) box.extend(p);
  }
  return box;
}

const Glyph* HersheyFont::find(char32_t c) const {
  if (c < 32 || c > 126 || c - 32 >= glyphs.size()) return nullptr;
  const Glyph& glyph = glyphs[c - 32];
  return glyph.strokes.empty() && c != ' ' ? nullptr : &glyph;
}

HersheyFont parse_jhf(std::string_view text, const std::string& name) {
  HersheyFont font{name, {}};
  const auto fail = [&](const std::string& what) {
    throw InputError(fmt::format("font {}: glyph {}: {}", name, font.glyphs.size(), what));
  };
  const auto line_end = [](char c) { return c == '\n' || c == '\r'; };
  std::size_t at = 0;
  const auto skip_line_ends = [&] {
    while (at < text.size() && line_end(text[at])) ++at;
  };
  for (skip_line_ends(); at < text.size(); skip_line_ends()) {
    if (text.size() - at < 8) fail("the file ends inside its header");
    std::string_view head = text.substr(at + 5, 3);
    while (head.starts_with(' ')) head.remove_prefix(1);
    int pairs = 0;
    const auto [end, error] = std::from_chars(head.data(), head.data() + head.size(), pairs);
    if (error != std::errc() || end != head.data() + head.size() || pairs < 1)
      fail("no number of pairs in columns 6 to 8");
    at += 8;
    std::string codes;
    for (; at < text.size() && codes.size() < 2 * static_cast<std::size_t>(pairs); ++at) {
      if (!line_end(text[at])) codes += text[at];
    }
    if (codes.size() < 2 * static_cast<std::size_t>(pairs))
      fail("the file ends before its last pair");
    Glyph glyph{static_cast<double>(codes[0] - 'R'), static_cast<double>(codes[1] - 'R'), {}};
    bool down = false;
    for (std::size_t i = 2; i < codes.size(); i += 2) {
      if (codes[i] == ' ' && codes[i + 1] == 'R') {
        down = false;
        continue;
      }
      if (!down) glyph.strokes.emplace_back();
      down = true;
      glyph.strokes.back().emplace_back(codes[i] - 'R', codes[i + 1] - 'R');
    }
    // Without a width, as in rowmant's J, the ink determines it.
    if (!glyph.strokes.empty() && glyph.right <= glyph.left) {
      const Eigen::AlignedBox2d ink = glyph.box();
      glyph.left = ink.min().x() - 2, glyph.right = ink.max().x() + 2;
    }
    font.glyphs.push_back(std::move(glyph));
    while (at < text.size() && !line_end(text[at])) {
      if (text[at++] != ' ') fail("more pairs than it says");
    }
  }
  if (font.glyphs.empty()) throw InputError(fmt::format("font {}: no glyph in it", name));
  return font;
}

std::filesystem::path hershey_folder() {
  std::error_code error;
  const std::filesystem::path own = data_folder() / "hershey-fonts";  // of the Python package
  return std::filesystem::is_directory(own, error) ? own : "/usr/share/hershey-fonts";
}

std::vector<std::string> hershey_font_names() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(hershey_folder(), error)) {
    if (entry.path().extension() == ".jhf") names.push_back(entry.path().stem());
  }
  if (names.empty()) {
    throw InputError(
        fmt::format("{}: has no fonts for text; Debian's package hershey-fonts-data provides them",
                    hershey_folder().string()));
  }
  std::sort(names.begin(), names.end());
  return names;
}

HersheyFont read_hershey_font(const std::string& name) {
  const std::vector<std::string> names = hershey_font_names();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    std::string known;
    for (const std::string& n : names) known += (known.empty() ? "" : ", ") + n;
    throw InputError(fmt::format("font '{}' is not known; there are {}", name, known));
  }
  std::ifstream in(hershey_folder() / (name + ".jhf"), std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  if (!in) throw InputError(fmt::format("font {}: cannot be read", name));
  return parse_jhf(text, name);
}

}  // namespace impedraw

// The Hershey fonts: letters as pen strokes, digitised by A. V. Hershey in 1967. The files (.jhf)
// are those of Debian's hershey-fonts-data.
//
// A glyph has its own grid: x right, y down, capitals from y = −12 to the baseline at y = 9,
// descenders to about 16. In a .jhf file a glyph is a number (5 columns, unused), a count (3
// columns), and that many pairs of characters; long glyphs continue on the next line. A character c
// encodes c − 'R'. The first pair holds the left and the right edge; " R" lifts the pen. Glyphs
// follow ASCII from 32, the space.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

constexpr double kCapTop = -12, kBaseline = 9, kCapHeight = kBaseline - kCapTop;  // [grid]

struct Glyph {
  double left = 0, right = 0;  // edges between letters [grid]
  // [grid], at least one point each; empty for a space
  std::vector<std::vector<Eigen::Vector2d>> strokes;

  Eigen::AlignedBox2d box() const;
};

struct HersheyFont {
  std::string name;
  std::vector<Glyph> glyphs;            // of the characters from 32 on
  std::map<char32_t, Glyph> more = {};  // of others; all of an SVG font

  const Glyph* find(char32_t c) const;  // null if the font has no such glyph
};

// A glyph as a .jhf file has it: left and right edge, then points, each as two characters, 'R' for
// 0; " R" lifts the pen. `more`: strokes that are no points of the grid.
Glyph hershey_glyph(std::string_view codes, std::vector<std::vector<Eigen::Vector2d>> more = {});
// InputError names the glyph at which the text is not valid .jhf.
HersheyFont parse_jhf(std::string_view text, const std::string& name);

std::filesystem::path hershey_folder();
// Sorted. InputError if the fonts are not installed.
std::vector<std::string> hershey_font_names();
// `name`: "futural", with Greek and Cyrillic from greeks and cyrillic; or the path of an SVG 1.1
// font (.svg), scaled to the same grid by the height of its capitals. InputError lists the
// available fonts, or names the file.
HersheyFont read_hershey_font(const std::string& name);

}  // namespace impedraw

// The Hershey fonts: letters as pen strokes, digitised by A. V. Hershey in 1967, as Debian's
// hershey-fonts-data has them (.jhf).
//
// A glyph lies on a grid of its own: x right, y down, capitals from y = −12 to the baseline at y =
// 9, descenders to about 16. In a .jhf file it is a number (5 columns, not used), a count (3
// columns), and so many pairs of characters, broken over lines where it is long. A character c
// stands for c − 'R'; the first pair holds the left and the right edge, " R" lifts the pen. Glyphs
// follow ASCII from 32, the blank.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

constexpr double kCapTop = -12, kBaseline = 9, kCapHeight = kBaseline - kCapTop;  // [grid]

struct Glyph {
  double left = 0, right = 0;  // edges between letters [grid]
  std::vector<std::vector<Eigen::Vector2d>>
      strokes;  // [grid], at least one point each; none: a blank

  Eigen::AlignedBox2d box() const;
};

struct HersheyFont {
  std::string name;
  std::vector<Glyph> glyphs;  // of the characters from 32

  const Glyph* find(char32_t c) const;  // null: no such place, or one that the font leaves empty
};

// InputError: text that is no .jhf; names the glyph.
HersheyFont parse_jhf(std::string_view text, const std::string& name);

std::filesystem::path hershey_folder();
std::vector<std::string>
hershey_font_names();  // sorted; InputError where the fonts are not installed
HersheyFont read_hershey_font(
    const std::string& name);  // "futural"; InputError names those that there are

}  // namespace impedraw

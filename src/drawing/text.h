// Sets text in single pen strokes, in a font (hershey.h) extended by letters.h.
//
// The page is that of any artwork: x right, y down [mm]. The first line's capitals reach from y = 0
// to y = size; each further line lies line_spacing · size lower. A line ends at a line feed, or at
// the two characters \n. Lines are aligned by their ink: left at x = 0, centred on it, or right at
// it. Spaces at either end of a line keep their width.
#pragma once

#include <optional>
#include <string>

#include "impedraw/common/range.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

enum class TextAlign { left, centre, right };
enum class SvgText { outline, single };  // of an SVG: outlines of its fonts' glyphs, or pen strokes

struct TextSettings {
  std::string text;              // UTF-8
  std::string font = "futural";  // a name in hershey_folder(), or an SVG 1.1 font's path
  // height of the capitals on the page; absent: 10, for text that is fitted later
  std::optional<double> size_mm;
  SvgText as = SvgText::outline;
  TextAlign align = TextAlign::left;
  double line_spacing = 1.8;  // between baselines, relative to the capitals' height

  struct Limits {
    static constexpr Limit size = {"size", "mm", Range::positive_to(1e4)};
    static constexpr Limit line_spacing = {"line_spacing", "", {0.1, 100.0}};
  };
};

// Returns strokes in reading order, on one layer, "text". InputError: an unknown font, invalid
// UTF-8, characters that the font lacks (each named with its position), nothing to draw, or a size
// or spacing out of range.
Artwork make_text(const TextSettings& settings);

}  // namespace impedraw

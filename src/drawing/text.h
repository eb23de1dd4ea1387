// Text as single pen strokes, in a Hershey font (hershey.h), with what letters.h adds to it.
//
// Set on a page like any artwork: x right, y down [mm]. The first line's capitals reach from y = 0
// to y = size, each next line stands line_spacing · size lower. A line ends at a line feed, or at
// the two characters \n. Lines are aligned by their ink: left at x = 0, centred about it, or right
// at it; blanks at either end of a line keep their width.
#pragma once

#include <optional>
#include <string>

#include "impedraw/common/range.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

enum class TextAlign { left, centre, right };

struct TextSettings {
  std::string text;              // UTF-8
  std::string font = "futural";  // a file of hershey_folder()
  std::optional<double>
      size_mm;  // height of the capitals on the page; absent: 10, for a text that is fitted anyway
  TextAlign align = TextAlign::left;
  double line_spacing = 1.8;  // from baseline to baseline, in heights of the capitals

  struct Limits {
    static constexpr Range size = Range::positive_to(1e4);  // [mm]
    static constexpr Range line_spacing = {0.1, 100.0};
  };
};

// Strokes in reading order, on one layer, "text". InputError: unknown font, invalid UTF-8,
// characters that the font has not (each named, with where it stands), nothing to draw, a size or
// spacing out of range.
Artwork make_text(const TextSettings& settings);

}  // namespace impedraw

// Strokes as lines of text: the stroke files of robot-drawing research, and the same as CSV.
//
//   200 150        width and height of the page
//   10 20          x y of a point, y down
//   30.5 20
//   End            closes a stroke; one of a single point is a dot
//   …
//
// Millimetres, unless StrokeFileSettings::unit says otherwise. Where it does not, and every
// coordinate lies between 0 and 1 while the page is larger than 1 × 1, the coordinates are shares
// of the page, as those programs write them, and are scaled to it (told in Artwork::warnings).
//
// Fields stand apart by blanks, or by commas or semicolons. Blank lines and lines that begin with #
// say nothing, `End` may be written in any case, and after the last stroke it may be missing
// (told).
//
// A CSV file may begin with a header, and then has no page of its own: the columns x and y, and
// perhaps `stroke`, whose value changes with every stroke. Without that column a blank line or
// `End` closes a stroke. A file of neither header nor `End` is of points alone, too: its first row
// is a point, and blank lines close its strokes.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

enum class PageUnit { file, mm, cm, in, m, px };  // file: as it says itself, or mm; px: 1/96 in
double millimetres(PageUnit unit);

struct StrokeFileSettings {
  PageUnit unit = PageUnit::file;  // of every number in it
  double largest_file_mb = 256;
  bool may_be_empty = false;  // nothing to draw is no error, but a warning
};

// InputError names the line: no size of the page, a field that is no number, not finite or beyond ±
// 1e6 mm, fields too few or too many.
Artwork read_strokes(const std::filesystem::path& file, const StrokeFileSettings& settings = {});
Artwork parse_strokes(std::string_view text, const std::string& name, bool csv,
                      const StrokeFileSettings& settings = {});

}  // namespace impedraw

// Reads strokes from text: the stroke files of robot-drawing research, and CSV.
//
//   200 150        width and height of the page; `200 150 width` or `200 150 force`: see below
//   10 20          x y of a point, y down
//   30.5 20
//   End            ends a stroke; a stroke of one point is a dot
//   …
//
// Coordinates are in millimetres unless StrokeFileSettings::unit is set. If it is not set, every
// coordinate lies between 0 and 1, and the page is larger than 1 × 1, the coordinates are fractions
// of the page, as those programs write them. They are then scaled to the page, with a warning.
//
// Fields are separated by blanks, commas or semicolons. Blank lines and lines that begin with # are
// ignored. `End` is case-insensitive and may be missing after the last stroke (with a warning).
//
// A CSV file may begin with a header: the columns x and y, and optionally `stroke`, whose value
// changes with every stroke; one with a column z and none of strokes is a point cloud, and refused.
// It then has no page size. Without that column a blank line or `End`
// ends a stroke. A file with neither a header nor `End` has only points: its first row is a point,
// and blank lines end its strokes.
//
// A third number at each point says how heavy the line is there: a column `width` of a CSV file, or
// that word behind the page's size, gives the line's width, in the unit of the coordinates (mm if
// those are fractions of the page); `force` gives the pen's force [N]. Neither is negative, and a
// file has one of them at most. Both change evenly from point to point.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

enum class PageUnit { file, mm, cm, in, m, px };  // file: the file's own, or mm; px: 1/96 in
double millimetres(PageUnit unit);

struct StrokeFileSettings {
  PageUnit unit = PageUnit::file;  // of every number in the file
  double largest_file_mb = 256;
  bool may_be_empty = false;  // nothing to draw is a warning, not an error
};

// InputError names the line: a missing page size, a field that is not a number, not finite or
// beyond ± 1e6 mm, or a wrong number of fields.
Artwork read_strokes(const std::filesystem::path& file, const StrokeFileSettings& settings = {});
Artwork parse_strokes(std::string_view text, const std::string& name, bool csv,
                      const StrokeFileSettings& settings = {});

}  // namespace impedraw

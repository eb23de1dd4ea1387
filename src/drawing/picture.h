// Strokes of a picture, PNG or JPEG, and centre lines of areas. Python makes them, with NumPy, SciPy,
// scikit-image and Pillow (python/impedraw/image, the extra `image`).
//
// A picture's tone becomes lines of one width whose ink, measured, has that tone when seen from
// afar. A style `trace` gives the centre lines of a scanned drawing instead, and of the filled areas
// of an SVG.
#pragma once

#include <filesystem>

#include "impedraw/common/range.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

enum class PictureStyle {
  stipple,      // one line through points, dense where it is dark
  hatch,        // parallel lines
  cross_hatch,  // in up to four directions
  flow,         // along the picture's edges
  contour,      // level lines, closer where it is dark
  trace         // centre lines of what is drawn
};

struct ImageSettings {
  PictureStyle style = PictureStyle::stipple;
  double size_mm = 180;     // the longer side of the page
  double pen_mm = 0.5;      // width of the line
  int points = 5000;        // of stipple
  double angle_deg = 45.0;  // of hatch and cross-hatch

  struct Limits {
    static constexpr Limit size = {"size", "mm", {1.0, 1e4}};
    static constexpr Limit pen = {"pen", "mm", {0.01, 100.0}};
    static constexpr Limit points = {"points", "", {3, 100'000}};
    static constexpr Limit angle = {"angle", "deg", {-360.0, 360.0}};
  };
};

bool is_picture_file(const std::filesystem::path& file);  // by extension, ignoring case

// One layer, "picture"; a warning tells the tone's correlation. The last picture is kept in memory.
// InputError: Python's packages are missing, the file is no such picture, is broken, too large or
// has nothing to draw.
Artwork read_picture(const std::filesystem::path& file, const ImageSettings& settings);

// Replaces filled areas, and their outlines, by their centre lines; strokes stay. `text`: only areas of
// text. InputError as above.
void trace_areas(Artwork& artwork, bool text = false);

}  // namespace impedraw

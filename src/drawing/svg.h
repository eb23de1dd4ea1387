// SVG documents as strokes.
//
// resvg's usvg interprets the document (styles, units, viewBox, transforms, use, markers, arcs);
// what is left is flattened here. 1 px is 1/96 inch, and a document without width and height takes
// its viewBox's units for px.
//
// A path draws if it is painted: filled, stroked or both, in whatever colour, white too (but not as
// the page's ground, below). Each subpath then is one stroke along its geometry, once, whatever the
// stroke's width. A subpath that is only filled is drawn closed, for so it looks (Stroke::edge).
// What a path fills, and how its stroke is dashed, are told beside (Artwork::areas, dashes) for
// hatch.h and dashes.h to apply; areas that are filled white are left out there, and one painted
// over another does not hide it. Opacity 0, display none, visibility hidden and elements outside of
// what is rendered draw nothing. Layers are the groups at the top of the document, by Inkscape
// label, id or place.
//
// Text is drawn as the outlines of its glyphs, in the system's fonts.
//
// Not drawn, and told in Artwork::warnings: pictures, markers, text that no font shows, filled
// shapes without an area, a white rectangle over the whole page, the effect of clip paths and
// masks, and what usvg could not make sense of. The contents of patterns are not drawn either, only
// what they fill. But for fonts, nothing except the file itself is read.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

struct SvgSettings {
  double tolerance_mm = 0.01;  // of a chord to its curve, on the page
  // of the artwork's diagonal; the smaller holds, since a small page is drawn enlarged
  double relative_tolerance = 1e-5;
  double turn = 0.15;  // largest turn of a curve from one point to the next [rad]
  double largest_file_mb = 64;
  bool may_be_empty = false;  // nothing to draw is no error, but a warning
};

// InputError: the file is missing or no SVG, has no valid size, nests beyond 1,000 elements, holds
// numbers that are not finite or a coordinate beyond ± 1e6 mm, or nothing in it draws.
Artwork read_svg(const std::filesystem::path& file, const SvgSettings& settings = {});
Artwork parse_svg(std::string_view document, const std::string& name,
                  const SvgSettings& settings = {});

}  // namespace impedraw

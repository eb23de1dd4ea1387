// Converts SVG documents to strokes.
//
// resvg's usvg interprets the document (styles, units, viewBox, transforms, use, markers, arcs).
// The resulting curves are flattened here. 1 px is 1/96 inch. A document without width and height
// takes its viewBox's units as px.
//
// A painted path is drawn, whether filled, stroked or both, in any colour but white. Each subpath
// becomes one stroke along its geometry, whatever the stroke width. A subpath that is only filled
// is drawn closed (Stroke::edge). Clip paths, masks, opaque fills and white strokes hide lines
// (visible.h); so do strokes beneath their width, and the page's edge. What is less opaque than
// one half, a pattern, and a picture hide nothing. With Visible::all, nothing is hidden, and white
// lines are drawn. A pattern is drawn tile by tile, and its shape's edge is not; one of over 10,000
// tiles counts as an even tone; a gradient's edge
// is left out where it is white or clear. The fill of an open path has an edge that closes it.
// Fills and dashes are returned in Artwork::areas and dashes, for hatch.h and dashes.h to apply;
// white fills are not. Markers are drawn. Elements with opacity 0, display none or visibility
// hidden, and elements that are not rendered, draw nothing. Layers are the document's top-level
// groups, named by Inkscape label, id or position, or its colours (layers.h).
//
// Text is drawn as the outlines of its glyphs, in the system's fonts, or in single strokes
// (svg_subpaths.h). A warning names a font that is not installed and the one that replaces it. What
// the internal DTD declares (namespaces, default attributes) counts. A pathLength stretches the
// dashes.
//
// Artwork::warnings tells what is lost, in the same words wherever it is printed: lengths that are
// hidden or doubled, white shapes, pictures, animations, text that no font can show, filled shapes
// without area, a white rectangle over the whole page, painted shapes that are hidden (display,
// visibility, opacity 0, an empty clip path), patterns of over 10,000 tiles, the effect of
// filters, partial opacity and different stroke widths, what the file refers to and does not hold,
// and anything that usvg could not interpret. A filter never hides a shape, not even one that is
// missing or empty. Of a pattern on a stroke only the line counts. Apart from fonts, only the file
// itself is read.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "impedraw/drawing/layers.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

struct SvgSettings {
  double tolerance_mm = 0.01;  // largest distance from a chord to its curve, on the page
  // the same, relative to the artwork's diagonal; the smaller tolerance applies, since a small page
  // is drawn enlarged
  double relative_tolerance = 1e-5;
  double turn = 0.15;  // largest turn of a curve between points [rad]
  double largest_file_mb = 64;
  bool may_be_empty = false;  // nothing to draw is a warning, not an error
  Visible visible = Visible::as_painted;
  LayerSource layers = LayerSource::automatic;
  // Text is drawn in this font's single strokes (hershey.h); empty: as outlines.
  std::string single_font = {};
};

// InputError: the file is missing or not an SVG, has no valid size, nests more than 1,000 elements
// deep, holds a number that is not finite or a coordinate beyond ± 1e6 mm, or draws nothing.
Artwork read_svg(const std::filesystem::path& file, const SvgSettings& settings = {});
Artwork parse_svg(std::string_view document, const std::string& name,
                  const SvgSettings& settings = {});

}  // namespace impedraw

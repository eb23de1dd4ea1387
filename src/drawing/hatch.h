// Filled areas as parallel pen strokes.
//
// The lines lie at (k + 1/2) · spacing from the page's origin, k whole, so that those of
// neighbouring areas meet. Each is clipped by the area's outlines and fill rule (Clipper) and drawn
// the other way round than the one beside it. Crossed, as many again stand across them.
//
// An area hides nothing that was painted before it: where areas overlap, each has its lines. One
// narrower than the spacing may get none.
#pragma once

#include <vector>

#include "impedraw/common/range.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

struct HatchSettings {
  double spacing_mm = 0;  // on the canvas, between neighbouring lines; 0: none
  double angle_deg = 45;  // of the lines to the page's X, counter-clockwise as the page is seen
  bool cross = false;     // a second set, at right angles
  // outlines of filled areas are drawn, too (those that are stroked always are)
  bool outline = true;

  struct Limits {
    static constexpr Range spacing = {0.0, 1000.0};  // [mm]
    static constexpr Range angle = {-360.0, 360.0};  // [deg]
  };
};

// The area's lines, at settings.spacing_mm / scale on the page; `scale` is of the placement. None
// for a spacing of 0. InputError: a spacing, scale or angle out of range, more than
// 100,000 lines across an area.
std::vector<Stroke> hatch_lines(const Area& area, const HatchSettings& settings, double scale);

// The artwork with every area's lines behind the other strokes of its layer, and without edges
// where settings.outline says so. The areas stay.
void apply_hatch(Artwork& artwork, const HatchSettings& settings, double scale);
void drop_edges(Artwork& artwork);

}  // namespace impedraw

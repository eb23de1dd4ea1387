// Fills areas with pen strokes: parallel ones, or rings (hatch_rings.h).
//
// The parallel lines lie at (k + 1/2) · spacing from the page's origin for integer k, so those of
// neighbouring areas meet. Each line is clipped by the area's outlines and fill rule (Clipper).
// Neighbouring lines are drawn in opposite directions. Cross-hatching adds a perpendicular set.
//
// An even tone of t has its lines 1/t times as far apart. One that varies has the lines of a full
// tone, each where the tone is above its threshold (hatch_rows.h).
//
// An area does not hide what was painted before it: overlapping areas each keep their lines. An
// area narrower than the spacing may get none.
//
// The spacing is the page's, which a wrapped page has on the surface, too. On a page that is
// projected it is measured on the surface (hatch_frame.h): lines bend, and keep their distance.
#pragma once

#include <vector>

#include "impedraw/common/range.h"
#include "impedraw/drawing/hatch_frame.h"
#include "impedraw/drawing/hatch_rings.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

struct HatchSettings {
  double spacing_mm = 0;  // between neighbouring lines of a full tone on the canvas; 0: no hatching
  HatchStyle style = HatchStyle::boustrophedon;
  double angle_deg = 45;  // from the page's X to the lines, counter-clockwise as seen
  bool cross = false;     // a second set, at right angles
  // draw the outlines of filled areas too (stroked outlines are always drawn)
  bool outline = true;

  struct Limits {
    static constexpr Limit spacing = {"spacing", "mm", {0.0, 1000.0}};
    static constexpr Limit angle = {"angle", "deg", {-360.0, 360.0}};
  };
};

// How lines are spaced on a surface; empty: as on the page.
struct HatchSurface {
  SurfaceDistances distances = {};
  HatchRings rings = {};
};

// Returns the area's lines at settings.spacing_mm / scale on the page, where `scale` is the
// placement's; none for a spacing of 0. InputError: spacing, scale or angle out of range, a second
// set of rings, or more than 100,000 lines across an area.
std::vector<Stroke> hatch_lines(const Area& area, const HatchSettings& settings, double scale,
                                const HatchSurface& surface = {});

// The same lines, joined where they can be drawn in one go (boustrophedon). A join stays within the
// area; the lines end half a pen before the outline.
std::vector<Stroke> hatch_strokes(const Area& area, const HatchSettings& settings, double scale);

// apply_hatch() puts each area's joined lines behind the other strokes of its layer, and drops the
// edges if settings.outline is false. drop_edges() only drops the edges. Both keep the areas.
void apply_hatch(Artwork& artwork, const HatchSettings& settings, double scale,
                 const HatchSurface& surface = {});
void drop_edges(Artwork& artwork);

}  // namespace impedraw

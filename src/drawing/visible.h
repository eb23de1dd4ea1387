// The visible parts of painted lines and areas: clip paths, masks and paint order.
//
// Paints lie over each other in their order. A line is visible outside what later paints hide and
// inside its clip. An area shrinks likewise, and the edge that the eye sees is drawn: also where a
// clip or something white cuts it. Where a later area that is inked hides it, that one's own edge
// is drawn instead. A line along the border of an area that hides is visible, as half of it is; one
// along the border of its clip too. Lines on the border are told apart from lines in it by 3e-6 of
// the drawing's diagonal. An edge or stroke is seen where the colours beside it differ: those that
// all paints give there, with their gradients and opacities (colours.h); and a slanted border
// between areas of one colour, where a screen shows a hairline. A stroke hides what lies beneath
// its width, but for strokes of its own colour and for what merely crosses it, up to 1/300 of the
// diagonal. Uncut lines and areas are returned as they came. Where a stroke's centre line is hidden
// and its rim is not (a road's casing), the middle of the rim is drawn.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "impedraw/drawing/clip_regions.h"
#include "impedraw/drawing/colours.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

struct Paint {
  std::vector<Stroke> strokes = {};  // what is inked; an area's edge has Stroke::edge set
  Area area = {};                    // what is filled; without outlines: nothing
  bool inked = false;                // the area is; else it is white
  bool hides = false;  // the area hides the paints from hides_from on, before this one
  std::size_t hides_from = 0;
  // Without that of groups; of a white area whose edge alone counts, 0.
  double opacity = 1, stroke_opacity = 1;
  // The tint of the gradients of area and strokes, if they have one.
  std::function<Tint(const Eigen::Vector2d&, bool of_stroke)> shade = {};
  bool shaded = false, shaded_strokes = false;
  int group = -1;      // around it; −1: none
  double soft = 0;     // deviation of a blur [mm]: the area has edges only where something cuts it
  bool round = false;  // the strokes' caps are
  std::size_t covers_from = -1;  // the strokes hide the paints from there on, before this one
  int clip = -1;                 // that cuts it; −1: none
  bool veil = false;             // a white area whose edge is seen on what it lets show
};

struct Hidden {
  double length = 0;  // of strokes [mm]
  // So much lies over one another that not all was looked at.
  bool in_part = false;
};

// Cuts the strokes and areas of the paints. Cut dashed strokes get dashes of their own, so that the
// pattern runs on. Returns what is hidden. InputError: outlines cross too often.
Hidden keep_visible(std::vector<Paint>& paints, const std::vector<Clip>& clips,
                    std::vector<Dash>& dashes, const std::vector<PaintGroup>& groups = {});

}  // namespace impedraw

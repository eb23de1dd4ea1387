// The built-in drawings: the paper's sine and M on the standard bowl, and a circle.
//
// Coordinates are millimetres on a page whose origin is the canvas's centre c. The page lies in the
// world with scale 1: x_world = c_x − Y/1000, y_world = c_y − X/1000 (X right and Y down on the
// page; placement.h). In the world, about c = (0.60, 0) m:
//   sine  x = 0.60 + 0.05 sin(2π (y + 0.15) / 0.15), y from −0.15 to 0.15
//   M     (0.52, 0.08) (0.68, 0.08) (0.60, 0) (0.68, −0.08) (0.52, −0.08), joined by straight lines
//   sine10  the sine's points at y_i = −0.15 + i/30, i = 0 … 9, joined by straight lines; the
//           target stays the smooth sine
//   circle  of radius 0.06 about c, closed, from (0.60, −0.06) towards −x
// The sine thus runs from the page's right (y = −0.15) to its left.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

struct Shape {
  Artwork drawn;  // the commanded strokes
  // The ideal result, where it is another, with as many strokes; points at most 0.1 mm apart,
  // exactly on the formula.
  std::optional<Artwork> ideal = std::nullopt;

  const Artwork& target() const { return ideal ? *ideal : drawn; }
};

std::vector<std::string> shape_names();     // M, sine, sine10, circle
Shape make_shape(const std::string& name);  // InputError lists the valid names

}  // namespace impedraw

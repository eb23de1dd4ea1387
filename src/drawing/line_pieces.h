// The parts of a line that show.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/drawing/regions.h"

namespace impedraw {

// A part of a line, and the length before it.
struct LinePiece {
  std::vector<Eigen::Vector2d> points;
  double start = 0, length = 0;
};

// A point of a line, and a step to its side as long as a border is wide.
struct Spot {
  Eigen::Vector2d p, side;
  bool touches(const RegionIndex& r) const { return r.inside(p + side) || r.inside(p - side); }
  bool within(const RegionIndex& r) const { return r.inside(p + side) && r.inside(p - side); }
};

// The parts of the line where visible(spot), which changes only where a side crosses an index.
std::vector<LinePiece> visible_pieces(const std::vector<Eigen::Vector2d>& line, double hair,
                                      const std::vector<const RegionIndex*>& indices,
                                      const std::function<bool(const Spot&)>& visible);

// The parts of the line where is_seen(point, direction), looked at every `step`.
std::vector<LinePiece> pieces_where(
    const std::vector<Eigen::Vector2d>& line, double step,
    const std::function<bool(const Eigen::Vector2d&, const Eigen::Vector2d&)>& is_seen);

// The line between two lengths along it.
std::vector<Eigen::Vector2d> line_part(const std::vector<Eigen::Vector2d>& line, double from,
                                       double to);

// True if a and b are a flat end of the line stroked with `width`.
bool is_stroke_end(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                   const std::vector<Eigen::Vector2d>& line, double width);

}  // namespace impedraw

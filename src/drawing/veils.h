// Edges of what lets something show.
//
// A white veil, as a highlight is, is seen on what has a colour beneath it: there its edge is drawn
// as that area's. Where two shadows of one colour lie side by side, as the parts of a box's shadow
// do, no edge is seen between them.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "impedraw/drawing/line_pieces.h"
#include "impedraw/drawing/regions.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

struct Paint;

class Veils {
 public:
  Veils(double hair, double shortest) : hair_(hair), shortest_(shortest) {}

  void add(const std::vector<Stroke>& edges, double opacity);
  bool reach(const Eigen::AlignedBox2d& box) const;
  // The edges that lie on the region of that colour, which is beneath all veils so far. They end
  // there: nothing beneath gets them.
  std::vector<LinePiece> take(const Outlines& region, std::uint32_t colour);

  void add_shadow(const Paint* paint, std::uint32_t colour, const Outlines& region);
  // The parts of an edge of the paint's shadow that are not between it and another one.
  std::vector<LinePiece> apart(const Paint* paint, const Stroke& edge, double hair) const;

 private:
  struct Edge {
    std::vector<Eigen::Vector2d> points;
    Eigen::AlignedBox2d box;
    double opacity;
  };
  struct Shadow {
    const Paint* paint;
    std::uint32_t colour;
    Eigen::AlignedBox2d box;
    RegionIndex index;
  };

  double hair_, shortest_;  // of an edge that is drawn [mm]
  std::vector<Edge> edges_;
  std::vector<Shadow> shadows_;
};

}  // namespace impedraw

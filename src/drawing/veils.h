// Edges of white veils, as highlights are: on what has a colour beneath they are drawn as that
// area's.
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "impedraw/drawing/line_pieces.h"
#include "impedraw/drawing/regions.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

class Veils {
 public:
  Veils(double hair, double shortest) : hair_(hair), shortest_(shortest) {}

  void add(const std::vector<Stroke>& edges);
  bool reach(const Eigen::AlignedBox2d& box) const;
  // The edges that lie on the region, which is beneath all veils so far. They end there: nothing
  // beneath gets them.
  std::vector<LinePiece> take(const Outlines& region);

 private:
  struct Edge {
    std::vector<Eigen::Vector2d> points;
    Eigen::AlignedBox2d box;
  };

  double hair_, shortest_;  // of an edge that is drawn [mm]
  std::vector<Edge> edges_;
};

}  // namespace impedraw

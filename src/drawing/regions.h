// Boolean operations on areas of a page (Clipper).
//
// A region is a set of outlines, each closed by a line from its last point to its first, such that
// a point is inside where its winding number is not 0. Results are free of overlaps: outer outlines
// turn one way, holes the other.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

using Outlines = std::vector<std::vector<Eigen::Vector2d>>;

inline constexpr double kMostReach = 2;  // of a stroke beside its line, in widths: mitres

Eigen::AlignedBox2d outlines_box(const Outlines& outlines);
double enclosed_area(const Outlines& outlines);  // of a result [mm²]

// Regions of one page. Coordinates are rounded to 1e-9 of the box. InputError: outlines that cross
// so often that Clipper might take more than a gigabyte.
class RegionMath {
 public:
  explicit RegionMath(const Eigen::AlignedBox2d& box);

  Outlines region(const Area& area) const;  // by the area's fill rule
  Outlines united(const Outlines& a, const Outlines& b = {}) const;
  Outlines common(const Outlines& a, const Outlines& b) const;
  Outlines without(const Outlines& a, const Outlines& b) const;
  // The area of a stroke of that width: its corners are mitred and its ends flat, or both round.
  Outlines stroked(const std::vector<Eigen::Vector2d>& line, double width, bool closed,
                   bool round = false) const;
  // The part of a region that lies at least `distance` inside its outlines, to 0.5 % of it.
  Outlines inset(const Outlines& region, double distance) const;

 private:
  Outlines run(int operation, const Outlines& a, const Outlines& b, bool even_odd) const;

  Eigen::Vector2d centre_;
  double fineness_;  // steps per millimetre
};

// Finds where lines cross a region's outlines.
class RegionIndex {
 public:
  explicit RegionIndex(const Outlines& region);

  bool empty() const { return edges_.empty(); }
  bool inside(const Eigen::Vector2d& p, bool even_odd = false) const;
  // Appends where, from 0 at a to 1 at b, the line crosses outlines, in no order.
  void crossings(const Eigen::Vector2d& a, const Eigen::Vector2d& b, std::vector<double>& at) const;

 private:
  struct Edge {
    Eigen::Vector2d a, b;
    double left() const { return std::min(a.x(), b.x()); }
  };
  // Clamped to the strips that there are.
  std::size_t strip_of(double y) const;

  // The edges of a strip that may reach x or lie beyond it, from left to right.
  std::span<const int> reaching(std::size_t strip, double x) const;

  std::vector<Edge> edges_;  // from left to right
  // Edges in strips of y, each from left to right, and where each strip starts and the last ends.
  std::vector<int> in_strips_;
  std::vector<std::size_t> starts_;
  Eigen::AlignedBox2d box_;
  double height_ = 1, widest_ = 0;  // of a strip; of the edges [mm]
};

}  // namespace impedraw

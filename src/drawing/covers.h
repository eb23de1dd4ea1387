// Covers that hide parts of a drawing, found by place.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/drawing/line_pieces.h"
#include "impedraw/drawing/regions.h"
#include "impedraw/drawing/stroke.h"

namespace impedraw {

// Edges of white veils, as highlights are: on what has a colour beneath they are drawn as that
// area's.
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

// True if the region holds the whole box.
bool holds(const Outlines& region, const Eigen::AlignedBox2d& box);

struct Cover {
  Outlines region;
  Eigen::AlignedBox2d box;
  bool inked = false;
  std::size_t hides_from = 0;
  std::uint32_t colour = 0;           // of a stroke
  std::optional<Outlines> seen = {};  // what something white above leaves of the region
};

// The covers over the paints that are looked at, from the last to the first.
class Covers {
 public:
  explicit Covers(const Eigen::AlignedBox2d& page) : page_(page), cells_(kCells * kCells) {}

  int add(Cover cover) {
    const int number = static_cast<int>(covers_.size());
    cover.box = outlines_box(cover.region);
    if (is_large(cover.box))
      large_.push_back(number);
    else
      each_cell(cover.box, [&](std::vector<int>& cell) { cell.push_back(number); });
    covers_.push_back(std::move(cover));
    return number;
  }

  // Those that hide something of paint `index` within the box.
  std::vector<int> over(const Eigen::AlignedBox2d& box, std::size_t index) const {
    std::vector<int> found;
    const auto look_in = [&](const std::vector<int>& cell) {
      for (const int i : cell) {
        if (covers_[i].hides_from <= index && covers_[i].box.intersects(box)) found.push_back(i);
      }
    };
    look_in(large_);
    each_cell(box, look_in);
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  const Cover& operator[](int i) const { return covers_[i]; }

  // The covers of the kind, united, as far as they reach into the box; of inked ones, what shows.
  Outlines united(const RegionMath& math, const std::vector<int>& covers, std::optional<bool> inked,
                  const Eigen::AlignedBox2d& box) const;
  // Unites many covers of one place, unless they only lie beside each other.
  void merge(const RegionMath& math, std::vector<int>& over);

 private:
  static constexpr int kCells = 64;           // along each side
  static constexpr std::size_t kMerged = 24;  // covers that are united

  void remove(int i) {
    std::erase(large_, i);
    if (!is_large(covers_[i].box))
      each_cell(covers_[i].box, [&](std::vector<int>& cell) { std::erase(cell, i); });
    covers_[i] = {};
  }

  bool is_large(const Eigen::AlignedBox2d& box) const {
    return (8 * box.sizes().array() > page_.sizes().array()).any();
  }

  template <class Do>
  void each_cell(const Eigen::AlignedBox2d& box, Do&& act) const {
    const auto cell = [&](const Eigen::Vector2d& p) {
      const Eigen::Vector2d share = (p - page_.min()).cwiseQuotient(page_.sizes().cwiseMax(1e-9));
      return Eigen::Vector2i((kCells * share.cwiseMax(0.0).cwiseMin(0.999)).cast<int>());
    };
    const Eigen::Vector2i from = cell(box.min()), to = cell(box.max());
    for (int y = from.y(); y <= to.y(); ++y) {
      for (int x = from.x(); x <= to.x(); ++x) act(cells_[y * kCells + x]);
    }
  }

  Eigen::AlignedBox2d page_;
  std::vector<Cover> covers_;
  std::vector<int> large_;  // those of more than an eighth of the page
  mutable std::vector<std::vector<int>> cells_;
};

}  // namespace impedraw

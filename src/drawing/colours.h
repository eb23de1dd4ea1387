// The colours of a painting, place by place.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/drawing/clip_regions.h"
#include "impedraw/drawing/regions.h"

namespace impedraw {

struct Paint;

using Tint = Eigen::Array4d;  // red, green, blue and opacity, from 0 to 1

// A group that is painted as a whole.
struct PaintGroup {
  int parent = -1;  // around it; −1: none
  double opacity = 1;
  std::uint8_t blend = 0;  // usvg::BlendMode
};

class Colours {
 public:
  // Strokes up to `thin` do not count, as edges may cross them.
  Colours(const std::vector<Paint>& paints, const std::vector<PaintGroup>& groups,
          ClipRegions& clips, const Eigen::AlignedBox2d& page, double thin);

  // The colour on white paper. Of a stroke of paint `own`, and of others in its colour, nothing
  // counts, or only that it lies there. Half of each layer counts that ends between p + side and
  // p − side, as when a screen shows its edge. nullopt: it has looked at too many.
  std::optional<Tint> at(const Eigen::Vector2d& p, int own = -1, std::uint32_t own_colour = 0,
                         bool with_own = false,
                         const Eigen::Vector2d& side = Eigen::Vector2d::Zero()) const;
  // True if the tint differs by `least` from all that at() gives beside strokes of that colour.
  // False: it may, or not.
  bool is_unlike_all(const Tint& tint, std::uint32_t own_colour, double least) const;

 private:
  struct Layer {
    int paint;
    bool of_stroke;
    Area area;                          // as painted; of strokes, only its colour until asked for
    std::vector<Stroke> strokes = {};   // whose area it is
    Eigen::AlignedBox2d box = {};       // that holds it
    std::optional<RegionIndex> region;  // made when a place in the box is first asked for
  };
  using Tints = std::vector<std::pair<int, Tint>>;  // and the group that each is in

  void add(Layer layer);
  std::size_t cell_of(const Eigen::Vector2d& p) const;
  double coverage(Layer& layer, const Eigen::Vector2d& p) const;
  Tint tint(int paint, bool of_stroke, std::uint32_t colour, const Eigen::Vector2d& p) const;
  bool is_within(int inner, int outer) const;  // of groups
  Tint mixed(const Tints& tints) const;

  const std::vector<Paint>& paints_;  // whose outlines may have been cut since
  const std::vector<PaintGroup>& groups_;
  ClipRegions& clips_;
  RegionMath math_;
  Eigen::AlignedBox2d page_;
  double thin_;
  mutable std::vector<Layer> layers_;    // from the first to the last painted
  std::vector<std::vector<int>> cells_;  // layers by place
  std::vector<int> large_;
  std::set<std::pair<bool, std::uint32_t>> colours_{{false, 0xffffff}};  // of strokes, of areas
  bool mixes_ = false;             // some layer is not of one colour that lets nothing show
  mutable std::size_t asked_ = 0;  // layers
};

}  // namespace impedraw

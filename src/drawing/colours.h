// The colours of a painting, place by place.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/drawing/clip_regions.h"
#include "impedraw/drawing/regions.h"

namespace impedraw {

struct Paint;

using Tint = Eigen::Array4d;  // red, green, blue and opacity, from 0 to 1

// What is painted as a whole.
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

 private:
  struct Layer {
    int paint;
    bool of_stroke, even_odd;
    std::uint32_t colour;
    RegionIndex region;
  };
  using Tints = std::vector<std::pair<int, Tint>>;  // and the group that each is in

  void add(Layer layer, Eigen::AlignedBox2d box);
  std::size_t cell_of(const Eigen::Vector2d& p) const;
  double coverage(const Layer& layer, const Eigen::Vector2d& p) const;
  Tint tint(int paint, bool of_stroke, std::uint32_t colour, const Eigen::Vector2d& p) const;
  bool is_within(int inner, int outer) const;  // of groups
  Tint mixed(const Tints& tints) const;

  const std::vector<Paint>& paints_;  // whose outlines may have been cut since
  const std::vector<PaintGroup>& groups_;
  ClipRegions& clips_;
  Eigen::AlignedBox2d page_;
  std::vector<Layer> layers_;            // from the first to the last painted
  std::vector<std::vector<int>> cells_;  // layers by place
  std::vector<int> large_;
  mutable std::size_t asked_ = 0;  // layers
};

}  // namespace impedraw

#include "impedraw/drawing/veils.h"

#include <algorithm>
#include <utility>

namespace impedraw {

using Eigen::AlignedBox2d;

void Veils::add(const std::vector<Stroke>& edges) {
  for (const Stroke& edge : edges) edges_.push_back({edge.points, outlines_box({edge.points})});
}

bool Veils::reach(const AlignedBox2d& box) const {
  return std::any_of(edges_.begin(), edges_.end(),
                     [&](const Edge& edge) { return edge.box.intersects(box); });
}

std::vector<LinePiece> Veils::take(const Outlines& region) {
  const AlignedBox2d box = outlines_box(region);
  const RegionIndex index(region);
  std::vector<LinePiece> taken;
  std::vector<Edge> left;
  for (Edge& edge : edges_) {
    if (!edge.box.intersects(box)) {
      left.push_back(std::move(edge));
      continue;
    }
    const auto pieces = [&](const auto& is_meant) {
      return visible_pieces(edge.points, hair_, {&index}, is_meant);
    };
    for (LinePiece& piece : pieces([&](const Spot& spot) { return !spot.touches(index); }))
      left.push_back({std::move(piece.points), edge.box});
    for (LinePiece& piece : pieces([&](const Spot& spot) { return spot.within(index); })) {
      if (piece.length > shortest_) taken.push_back(std::move(piece));
    }
  }
  edges_ = std::move(left);
  return taken;
}

}  // namespace impedraw

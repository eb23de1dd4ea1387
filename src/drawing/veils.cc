#include "impedraw/drawing/veils.h"

#include <algorithm>
#include <utility>

namespace impedraw {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;
constexpr double kClear = 24;            // of 255: change of a channel that is a line
constexpr std::size_t kMostBeside = 64;  // shadows that are compared with one

void Veils::add(const std::vector<Stroke>& edges, double opacity) {
  for (const Stroke& edge : edges)
    edges_.push_back({edge.points, outlines_box({edge.points}), opacity});
}

bool Veils::reach(const AlignedBox2d& box) const {
  return std::any_of(edges_.begin(), edges_.end(),
                     [&](const Edge& edge) { return edge.box.intersects(box); });
}

std::vector<LinePiece> Veils::take(const Outlines& region, std::uint32_t colour) {
  const AlignedBox2d box = outlines_box(region);
  const RegionIndex index(region);
  const std::uint32_t darkest = std::min({colour >> 16 & 0xff, colour >> 8 & 0xff, colour & 0xff});
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
      left.push_back({std::move(piece.points), edge.box, edge.opacity});
    if (edge.opacity * (255 - darkest) < kClear) continue;
    for (LinePiece& piece : pieces([&](const Spot& spot) { return spot.within(index); })) {
      if (piece.length > shortest_) taken.push_back(std::move(piece));
    }
  }
  edges_ = std::move(left);
  return taken;
}

void Veils::add_shadow(const Paint* paint, std::uint32_t colour, const Outlines& region) {
  shadows_.push_back({paint, colour, outlines_box(region), RegionIndex(region)});
}

std::vector<LinePiece> Veils::apart(const Paint* paint, const Stroke& edge, double hair) const {
  AlignedBox2d box = outlines_box({edge.points});
  box.extend(box.max() + Vector2d::Constant(hair)).extend(box.min() - Vector2d::Constant(hair));
  const auto own = std::find_if(shadows_.begin(), shadows_.end(),
                                [&](const Shadow& shadow) { return shadow.paint == paint; });
  std::vector<const RegionIndex*> indices;
  for (const Shadow& one : shadows_) {
    const bool near = own != shadows_.end() && one.colour == own->colour && one.box.intersects(box);
    if (near && indices.size() < kMostBeside) indices.push_back(&one.index);
  }
  return visible_pieces(edge.points, hair, indices, [&](const Spot& spot) {
    const Vector2d a = spot.p + spot.side, b = spot.p - spot.side;
    return std::none_of(indices.begin(), indices.end(), [&](const RegionIndex* other) {
      return own->index.inside(a) != own->index.inside(b) && other->inside(a) != other->inside(b) &&
             own->index.inside(a) == other->inside(b);
    });
  });
}

}  // namespace impedraw

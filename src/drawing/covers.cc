#include "impedraw/drawing/covers.h"

#include "impedraw/common/cross.h"

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

using Eigen::Vector2d;

bool holds(const Outlines& region, const AlignedBox2d& box) {
  int winding = 0;
  const Vector2d p = box.min();
  for (const auto& outline : region) {
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
      if (AlignedBox2d(a.cwiseMin(b), a.cwiseMax(b)).intersects(box)) return false;
      if ((a.y() <= p.y()) == (b.y() <= p.y())) continue;
      const bool up = a.y() <= p.y();
      if (up == (cross(Vector2d(b - a), Vector2d(p - a)) > 0)) winding += up ? 1 : -1;
    }
  }
  return winding != 0;
}

Outlines Covers::united(const RegionMath& math, const std::vector<int>& covers,
                        std::optional<bool> inked, const AlignedBox2d& box) const {
  Outlines all;
  for (const int i : covers) {
    if (inked && covers_[i].inked != *inked) continue;
    const bool shown = inked && *inked && covers_[i].seen;
    for (const auto& outline : shown ? *covers_[i].seen : covers_[i].region) {
      if (outlines_box({outline}).intersects(box)) all.push_back(outline);
    }
  }
  return all.empty() ? all : math.united(all);
}

void Covers::merge(const RegionMath& math, std::vector<int>& over) {
  for (const bool inked : {false, true}) {
    std::vector<int> members;
    std::size_t points = 0, left = 0;
    for (const int i : over) {
      if (covers_[i].inked != inked || covers_[i].hides_from > 0) continue;
      members.push_back(i);
      for (const auto& outline : covers_[i].region) points += outline.size();
    }
    if (members.size() < kMerged) continue;
    AlignedBox2d box;
    for (const int i : members) box.extend(covers_[i].box);
    Outlines all = united(math, members, {}, box);
    for (const auto& outline : all) left += outline.size();
    if (left > points / 2) continue;
    std::optional<Outlines> seen;
    if (std::any_of(members.begin(), members.end(), [&](int i) { return covers_[i].seen; }))
      seen = united(math, members, true, box);
    for (const int i : members) {
      remove(i);
      std::erase(over, i);
    }
    over.push_back(add({std::move(all), {}, inked, 0, 0, std::move(seen)}));
  }
}

}  // namespace impedraw

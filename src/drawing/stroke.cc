#include "impedraw/drawing/stroke.h"

#include <utility>

#include "impedraw/drawing/order.h"

namespace impedraw {

Stroke like(const Stroke& stroke, std::vector<Eigen::Vector2d> points, bool closed) {
  Stroke other{std::move(points), closed,        stroke.layer, stroke.dash,
               stroke.edge,       stroke.colour, stroke.width};
  other.by_force = stroke.by_force;
  return other;
}

void drop_empty_layers(Artwork& artwork, bool keep_areas) {
  std::vector<int> strokes(artwork.layers.size(), 0), index(artwork.layers.size(), 0);
  for (const Stroke& stroke : artwork.strokes) ++strokes[stroke.layer];
  if (keep_areas)
    for (const Area& area : artwork.areas) ++strokes[area.layer];
  std::vector<std::string> kept;
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    index[i] = static_cast<int>(kept.size());
    if (strokes[i] > 0) kept.push_back(artwork.layers[i]);
  }
  std::erase_if(artwork.areas, [&](const Area& area) { return strokes[area.layer] == 0; });
  for (Area& area : artwork.areas) area.layer = index[area.layer];
  for (Stroke& stroke : artwork.strokes) stroke.layer = index[stroke.layer];
  artwork.layers = std::move(kept);
}

StrokeStatistics stroke_statistics(const std::vector<Stroke>& strokes) {
  StrokeStatistics statistics{strokes.size(), 0, pen_down_length(strokes), pen_up_length(strokes)};
  for (const Stroke& stroke : strokes) statistics.points += stroke.points.size();
  return statistics;
}

Eigen::AlignedBox2d bounds_of(const std::vector<Stroke>& strokes) {
  Eigen::AlignedBox2d box;
  for (const Stroke& stroke : strokes)
    for (const Eigen::Vector2d& p : stroke.points) box.extend(p);
  return box;
}

}  // namespace impedraw

#include "impedraw/drawing/clip_regions.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace impedraw {

constexpr double kLevels = 255;            // of a mask's luminance
constexpr std::size_t kMostRegions = 500;  // that are kept

// A mask's levels stand for its luminance.
const ClipRegions::Shown& ClipRegions::of(int clip) {
  if (const auto known = regions_.find(clip); known != regions_.end()) return known->second;
  const Clip& c = clips_[clip];
  std::map<int, Outlines> levels;  // by luminance; where none is, it is 0
  Outlines all;
  // A single shape is its own region: the rest of what follows is for more.
  const bool single = !c.mask && c.shapes.size() == 1 && !c.shapes[0].area.even_odd;
  for (const ClipShape& shape : c.shapes) {
    Outlines region = single ? shape.area.outlines : math_.region(shape.area);
    if (shape.clip >= 0) region = math_.common(region, of(shape.clip).region);
    if (!c.mask) {
      all.insert(all.end(), region.begin(), region.end());
      continue;
    }
    std::map<int, Outlines> painted;
    const auto put = [&](int level, const Outlines& part) {
      if (!part.empty()) painted[level].insert(painted[level].end(), part.begin(), part.end());
    };
    const double light = kLevels * shape.alpha * shape.value;
    Outlines rest = region;
    for (const auto& [level, part] : levels) {
      put(static_cast<int>(std::lround(level * (1 - shape.alpha) + light)),
          math_.common(part, region));
      put(level, math_.without(part, region));
      rest = math_.without(rest, part);
    }
    put(static_cast<int>(std::lround(light)), rest);
    levels = std::move(painted);
  }
  for (const auto& [level, part] : levels) {
    if (level > kLevels / 2) all.insert(all.end(), part.begin(), part.end());
  }
  Outlines shown = single ? std::move(all) : math_.united(all);
  if (c.parent >= 0) shown = math_.common(shown, of(c.parent).region);
  RegionIndex index(shown);
  return regions_.emplace(clip, Shown{std::move(shown), std::move(index)}).first->second;
}

double ClipRegions::light(int clip, const Eigen::Vector2d& p) {
  const Clip& c = clips_[clip];
  const double around = c.parent < 0 ? 1 : light(c.parent, p);
  if (around == 0) return 0;
  const auto [shapes, is_new] = shapes_.try_emplace(clip);
  for (std::size_t i = 0; is_new && i < c.shapes.size(); ++i)
    shapes->second.emplace_back(c.shapes[i].area.outlines);
  double light = 0;
  for (std::size_t i = 0; i < c.shapes.size(); ++i) {
    const ClipShape& shape = c.shapes[i];
    if (!shapes->second[i].inside(p, shape.area.even_odd)) continue;
    const double alpha = shape.alpha * (shape.clip < 0 ? 1 : this->light(shape.clip, p));
    light = c.mask ? (1 - alpha) * light + alpha * shape.value : std::max(light, alpha);
  }
  return around * light;
}

void ClipRegions::forget() {
  if (regions_.size() > kMostRegions) regions_.clear();
}

}  // namespace impedraw

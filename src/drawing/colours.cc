#include "impedraw/drawing/colours.h"

#include <algorithm>
#include <cmath>

#include "impedraw/drawing/visible.h"

namespace impedraw {

using Eigen::AlignedBox2d;
using Eigen::Array3d;
using Eigen::Vector2d;

namespace {

constexpr int kCells = 64;                     // along each side of the page
constexpr std::size_t kMostAsked = 5'000'000;  // layers, in all
constexpr std::size_t kMostOffset = 100'000;   // points of strokes that become areas
constexpr double kOpaque = 0.999;
constexpr int kSamples = 60;  // of a blur

Array3d mixed_by(std::uint8_t mode, const Array3d& over, const Array3d& under) {
  switch (mode) {  // usvg::BlendMode
    case 1:
      return over * under;  // multiply
    case 2:
      return over + under - over * under;  // screen
    case 4:
      return over.min(under);
    case 5:
      return over.max(under);
    default:
      return over;
  }
}

void put(const Tint& over, std::uint8_t blend, Tint& under) {
  const double a = over[3], b = under[3], all = a + b * (1 - a);
  if (!(all > 0)) return;
  const Array3d mix = mixed_by(blend, over.head<3>(), under.head<3>());
  under.head<3>() =
      (a * ((1 - b) * over.head<3>() + b * mix) + (1 - a) * b * under.head<3>()) / all;
  under[3] = all;
}

Tint tint_of(std::uint32_t colour) {
  const auto part = [&](int shift) { return (colour >> shift & 0xff) / 255.0; };
  return {part(16), part(8), part(0), 1};
}

}  // namespace

Colours::Colours(const std::vector<Paint>& paints, const std::vector<PaintGroup>& groups,
                 ClipRegions& clips, const AlignedBox2d& page, double thin)
    : paints_(paints),
      groups_(groups),
      clips_(clips),
      math_(page),
      page_(page),
      thin_(thin),
      cells_(kCells * kCells) {
  std::size_t offset = 0;
  for (const Paint& paint : paints) {
    const int number = static_cast<int>(&paint - paints.data());
    if (paint.opacity > 0 && !paint.area.outlines.empty()) {
      Layer layer{number, false, paint.area, {}, {}, {}};
      if (!paint.inked) layer.area.colour = 0xffffff;
      const Vector2d spare = Vector2d::Constant(3 * paint.soft);
      const AlignedBox2d box = outlines_box(layer.area.outlines);
      layer.box = {box.min() - spare, box.max() + spare};
      add(std::move(layer));
    }
    Layer layer{number, true, {}, {}, {}, {}};
    for (const Stroke& line : paint.strokes) {
      if (line.edge || line.dash >= 0 || line.width <= thin) continue;
      offset += line.points.size();
      if (offset > kMostOffset) break;
      const Vector2d beside = Vector2d::Constant(kMostReach * line.width);
      for (const Vector2d& p : line.points) layer.box.extend(AlignedBox2d(p - beside, p + beside));
      layer.strokes.push_back(line);
    }
    if (layer.strokes.empty()) continue;
    layer.area.colour = paint.strokes.back().colour;
    add(std::move(layer));
  }
}

void Colours::add(Layer layer) {
  const int number = static_cast<int>(layers_.size());
  const Paint& paint = paints_[layer.paint];
  const bool shaded = layer.of_stroke ? paint.shaded_strokes : paint.shaded;
  const double opacity = layer.of_stroke ? paint.stroke_opacity : paint.opacity;
  mixes_ |= shaded || opacity < 1 || paint.soft > 0 || paint.group >= 0 || paint.clip >= 0;
  colours_.emplace(layer.of_stroke, layer.area.colour);
  layers_.push_back(std::move(layer));
  const AlignedBox2d& box = layers_.back().box;
  if ((8 * box.sizes().array() > page_.sizes().array()).any()) return large_.push_back(number);
  const Vector2d cell = page_.sizes() / kCells;
  for (double y = box.min().y(); y < box.max().y() + cell.y(); y += cell.y()) {
    for (double x = box.min().x(); x < box.max().x() + cell.x(); x += cell.x()) {
      std::vector<int>& there = cells_[cell_of({x, y})];
      if (there.empty() || there.back() != number) there.push_back(number);
    }
  }
}

std::size_t Colours::cell_of(const Vector2d& p) const {
  const Vector2d share = (p - page_.min()).cwiseQuotient(page_.sizes().cwiseMax(1e-9));
  const Eigen::Vector2i at = (kCells * share.cwiseMax(0.0).cwiseMin(0.999)).cast<int>();
  return static_cast<std::size_t>(at.y()) * kCells + static_cast<std::size_t>(at.x());
}

double Colours::coverage(Layer& layer, const Vector2d& p) const {
  const Paint& paint = paints_[layer.paint];
  if (paint.soft == 0 && !layer.box.contains(p)) return 0;
  if (!layer.region) {
    for (const Stroke& line : layer.strokes) {
      // An edge along its rim is seen.
      const double width = line.width - thin_ / 16;
      for (auto& outline : math_.stroked(line.points, width, line.closed, paint.round))
        layer.area.outlines.push_back(std::move(outline));
    }
    layer.region.emplace(layer.area.outlines);
    layer.area.outlines.clear(), layer.strokes.clear();
  }
  const bool even_odd = layer.area.even_odd;
  if (paint.soft == 0) return layer.region->inside(p, even_odd);
  int inside = 0;
  for (int i = 0; i < kSamples; ++i) {  // a sunflower of even shares of the blur
    const double r = paint.soft * std::sqrt(-2 * std::log((i + 0.5) / kSamples)),
                 angle = 2.39996 * i;
    inside += layer.region->inside(p + r * Vector2d(std::cos(angle), std::sin(angle)), even_odd);
  }
  return static_cast<double>(inside) / kSamples;
}

Tint Colours::tint(int number, bool of_stroke, std::uint32_t colour, const Vector2d& p) const {
  const Paint& paint = paints_[number];
  const bool shaded = of_stroke ? paint.shaded_strokes : paint.shaded;
  Tint tint = shaded ? paint.shade(p, of_stroke) : tint_of(colour);
  tint[3] *= of_stroke ? paint.stroke_opacity : paint.opacity;
  if (paint.clip >= 0) tint[3] *= clips_.light(paint.clip, p);
  return tint;
}

std::optional<Tint> Colours::at(const Vector2d& p, int own, std::uint32_t own_colour, bool with_own,
                                const Vector2d& side) const {
  const std::vector<int>& cell = cells_[cell_of(p)];
  auto large = large_.rbegin();
  auto small = cell.rbegin();
  Tints tints;  // from the last to the first painted
  bool is_opaque = false;
  const auto take = [&](int paint, bool of_stroke, std::uint32_t colour, double covered) {
    Tint tint = this->tint(paint, of_stroke, colour, p);
    tint[3] *= covered;
    if (tint[3] > 0) tints.emplace_back(paints_[paint].group, tint);
    is_opaque = tint[3] > kOpaque && paints_[paint].group < 0;
  };
  while (!is_opaque) {
    const int next =
        std::max(large == large_.rend() ? -1 : *large, small == cell.rend() ? -1 : *small);
    if (with_own && (next < 0 || layers_[next].paint <= own)) {
      with_own = false;
      take(own, true, own_colour, 1);
      continue;
    }
    if (next < 0) break;
    large != large_.rend() && *large == next ? void(++large) : void(++small);
    Layer& layer = layers_[next];
    if (++asked_ > kMostAsked) return std::nullopt;
    // A stroke on one of its colour is one more line of the pen.
    if (own >= 0 && layer.of_stroke && layer.area.colour == own_colour) continue;
    double covered = coverage(layer, p + side);
    if (!side.isZero(0.0)) covered = (covered + coverage(layer, p - side)) / 2;
    if (covered > 0) take(layer.paint, layer.of_stroke, layer.area.colour, covered);
  }
  std::reverse(tints.begin(), tints.end());
  return mixed(tints);
}

bool Colours::is_unlike_all(const Tint& tint, std::uint32_t own_colour, double least) const {
  return !mixes_ && std::all_of(colours_.begin(), colours_.end(), [&](const auto& layers) {
    const auto [of_stroke, colour] = layers;
    return (of_stroke && colour == own_colour) || ((tint_of(colour) - tint).abs() >= least).any();
  });
}

bool Colours::is_within(int inner, int outer) const {
  while (inner > outer) inner = groups_[inner].parent;  // a group stands behind its parent
  return inner == outer;
}

Tint Colours::mixed(const Tints& tints) const {
  Tints open{{-1, Tint::Ones()}};
  const auto close = [&] {
    auto [group, tint] = open.back();
    open.pop_back();
    tint[3] *= groups_[group].opacity;
    put(tint, groups_[group].blend, open.back().second);
  };
  for (const auto& [group, tint] : tints) {
    while (!is_within(group, open.back().first)) close();
    const std::size_t first = open.size();
    for (int g = group; g != open[first - 1].first; g = groups_[g].parent)
      open.insert(open.begin() + static_cast<long>(first), {g, Tint::Zero()});
    put(tint, 0, open.back().second);
  }
  while (open.size() > 1) close();
  return open.front().second;
}

}  // namespace impedraw

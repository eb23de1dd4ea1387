#include "impedraw/drawing/hatch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/drawing/hatch_rows.h"
#include "impedraw/drawing/regions.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr double kShortest = 1e-5;  // [mm]
constexpr double kInset = 0.25;  // of joined lines from the outline: half a pen [mm on the canvas]
constexpr double kJoin = 3.0;    // longest way from inset to inset, and where tones vary [spacings]
constexpr double kBend = 2.0;    // between points of a line that follows the surface [mm there]

// An area in the frame of a set of lines.
struct AreaInFrame {
  Eigen::AlignedBox2d box;  // of the outlines in H
  Outlines outlines;        // of the area in H, free of overlaps
};

AreaInFrame in_frame(const HatchFrame& frame, const Area& area) {
  AreaInFrame t;
  Area in_H = area;
  std::erase_if(in_H.outlines, [](const auto& outline) { return outline.empty(); });
  for (auto& outline : in_H.outlines) outline = frame.outline_to_H(outline);
  t.box = outlines_box(in_H.outlines);
  if (!t.box.isEmpty()) t.outlines = RegionMath(t.box).region(in_H);
  return t;
}

// One set of lines, in H.
std::vector<HatchLine> set_of_lines(const Eigen::AlignedBox2d& box, const RegionIndex& region,
                                    double spacing) {
  std::vector<HatchLine> lines;
  if (box.isEmpty()) return lines;
  const double first = std::ceil(box.min().y() / spacing - 0.5),
               last = std::floor(box.max().y() / spacing - 0.5);
  require_few_rows(box.sizes().y(), spacing);
  std::vector<double> at;
  for (double k = first; k <= last; ++k) {
    const double y = (k + 0.5) * spacing;
    const Vector2d from(box.min().x() - spacing / 2, y), to(box.max().x() + spacing / 2, y);
    const auto x_at = [&](double share) { return from.x() + share * (to.x() - from.x()); };
    at.clear();
    region.crossings(from, to, at);
    std::sort(at.begin(), at.end());
    std::vector<std::pair<double, double>> row;  // parts inside, joined where they touch [mm]
    for (std::size_t i = 1; i < at.size(); ++i) {
      const double a = x_at(at[i - 1]), b = x_at(at[i]);
      if (!region.inside({(a + b) / 2, y})) continue;
      if (!row.empty() && a - row.back().second < kShortest)
        row.back().second = b;
      else
        row.emplace_back(a, b);
    }
    std::erase_if(row, [](const auto& part) { return part.second - part.first < kShortest; });
    const std::int64_t number = std::llround(k);
    if (number % 2 != 0) {
      std::reverse(row.begin(), row.end());
      for (auto& [a, b] : row) std::swap(a, b);
    }
    for (const auto& [a, b] : row) lines.push_back({{{a, y}, {b, y}}, number});
  }
  return lines;
}

// The frames of the sets of lines; none without hatching. Rings lie in the frame of the page.
std::vector<HatchFrame> frames_of(const HatchSettings& settings, double scale,
                                  const HatchSurface& surface, const Eigen::AlignedBox2d& box) {
  require_in_range("hatch", HatchSettings::Limits::spacing, settings.spacing_mm);
  require_in_range("hatch", HatchSettings::Limits::angle, settings.angle_deg);
  require_in_range("the hatch's scale", scale, Range::positive(), "");
  const bool rings = settings.style != HatchStyle::boustrophedon;
  if (rings && settings.cross)
    throw InputError("hatch: cross is for style=boustrophedon: rings have no second set of lines");
  std::vector<HatchFrame> frames;
  if (settings.spacing_mm == 0 || box.isEmpty()) return frames;
  if (rings) frames.emplace_back(0.0, SurfaceDistances(), box, 0.0);
  for (int set = 0; !rings && set < (settings.cross ? 2 : 1); ++set)
    frames.emplace_back((settings.angle_deg + 90.0 * set) * std::numbers::pi / 180,
                        surface.distances, box, kBend / scale);
  return frames;
}

std::vector<Stroke> hatch(const Area& area, const std::vector<HatchFrame>& frames,
                          const HatchSettings& settings, double scale, const HatchSurface& surface,
                          bool joined) {
  std::vector<Stroke> strokes;
  const bool rings = settings.style != HatchStyle::boustrophedon, even = !area.tone_at;
  const bool short_joins = settings.style == HatchStyle::contour_parallel || !even;
  if (!(area.tone > 0)) return strokes;
  const double full = settings.spacing_mm / scale, spacing = even ? full / area.tone : full,
               inset = std::min(settings.spacing_mm / 2, kInset) / scale;
  for (const HatchFrame& frame : frames) {
    const AreaInFrame t = in_frame(frame, area);
    const RegionIndex region(t.outlines);
    std::vector<HatchLine> lines = !rings ? set_of_lines(t.box, region, spacing)
                                   : surface.rings
                                       ? surface.rings(t.outlines, settings.style, spacing)
                                       : page_rings(t.outlines, settings.style, spacing);
    if (rings) lines = lines_inside(lines, region);
    if (!even)
      lines = lines_of_tone(lines, spacing / 2,
                            [&](const Vector2d& p) { return area.tone_at(frame.to_page(p)); });
    std::vector<std::vector<Vector2d>> drawn;
    if (joined)
      drawn = flowing(std::move(lines), region, inset, short_joins ? kJoin * spacing : INFINITY);
    else
      for (HatchLine& line : lines) drawn.push_back(std::move(line.points));
    for (const auto& line : drawn) {
      Stroke stroke{frame.line_to_page(line)};
      stroke.closed = line.size() > 2 && line.front() == line.back();
      stroke.layer = area.layer, stroke.colour = area.colour;
      strokes.push_back(std::move(stroke));
    }
  }
  return strokes;
}

}  // namespace

std::vector<Stroke> hatch_strokes(const Area& area, const HatchSettings& settings, double scale) {
  const auto frames = frames_of(settings, scale, {}, outlines_box(area.outlines));
  return hatch(area, frames, settings, scale, {}, true);
}

std::vector<Stroke> hatch_lines(const Area& area, const HatchSettings& settings, double scale,
                                const HatchSurface& surface) {
  const auto frames = frames_of(settings, scale, surface, outlines_box(area.outlines));
  return hatch(area, frames, settings, scale, surface, false);
}

void drop_edges(Artwork& artwork) {
  std::erase_if(artwork.strokes, [](const Stroke& stroke) { return stroke.edge; });
}

void apply_hatch(Artwork& artwork, const HatchSettings& settings, double scale,
                 const HatchSurface& surface) {
  if (!settings.outline) drop_edges(artwork);
  Eigen::AlignedBox2d box;
  for (const Area& area : artwork.areas) box.extend(outlines_box(area.outlines));
  const std::vector<HatchFrame> frames = frames_of(settings, scale, surface, box);
  std::vector<std::vector<Stroke>> lines(artwork.layers.size());
  for (const Area& area : artwork.areas) {
    const std::vector<Stroke> of_area = hatch(area, frames, settings, scale, surface, true);
    lines[area.layer].insert(lines[area.layer].end(), of_area.begin(), of_area.end());
  }
  for (std::size_t layer = 0; layer < lines.size(); ++layer) {
    const auto on_layer = [&](const Stroke& stroke) {
      return stroke.layer == static_cast<int>(layer);
    };
    const auto last = std::find_if(artwork.strokes.rbegin(), artwork.strokes.rend(), on_layer);
    const auto place = last == artwork.strokes.rend() ? artwork.strokes.end() : last.base();
    artwork.strokes.insert(place, lines[layer].begin(), lines[layer].end());
  }
  drop_empty_layers(artwork);
}

}  // namespace impedraw

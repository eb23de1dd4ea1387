#include "impedraw/drawing/hatch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/drawing/regions.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr double kMostLines = 100'000;
constexpr double kShortest = 1e-5;  // [mm]
constexpr double kInset = 0.25;  // of joined lines from the outline: half a pen [mm on the canvas]
constexpr double kBend = 2.0;    // between points of a line that follows the surface [mm there]

// An area in the frame of a set of lines.
struct AreaInFrame {
  Eigen::AlignedBox2d box;  // of the outlines in H
  RegionIndex region;       // of the area in H
};

AreaInFrame in_frame(const HatchFrame& frame, const Area& area) {
  AreaInFrame t{{}, RegionIndex({})};
  Area in_H = area;
  std::erase_if(in_H.outlines, [](const auto& outline) { return outline.empty(); });
  for (auto& outline : in_H.outlines) outline = frame.outline_to_H(outline);
  t.box = outlines_box(in_H.outlines);
  if (!t.box.isEmpty()) t.region = RegionIndex(RegionMath(t.box).region(in_H));
  return t;
}

// One set of lines, in H.
std::vector<Stroke> set_of_lines(const AreaInFrame& t, const Area& area, double spacing) {
  std::vector<Stroke> lines;
  if (t.box.isEmpty()) return lines;
  const double first = std::ceil(t.box.min().y() / spacing - 0.5),
               last = std::floor(t.box.max().y() / spacing - 0.5);
  if (last - first > kMostLines) {
    throw InputError(
        fmt::format("hatch: an area of {:.4g} mm across would take {:.3g} lines {:.3g} mm apart on "
                    "the page; at most {:.0e} "
                    "are drawn",
                    t.box.sizes().y(), last - first, spacing, kMostLines));
  }
  std::vector<double> at;
  for (double k = first; k <= last; ++k) {
    const double y = (k + 0.5) * spacing;
    const Vector2d from(t.box.min().x() - spacing / 2, y), to(t.box.max().x() + spacing / 2, y);
    const auto x_at = [&](double share) { return from.x() + share * (to.x() - from.x()); };
    at.clear();
    t.region.crossings(from, to, at);
    std::sort(at.begin(), at.end());
    std::vector<std::pair<double, double>> row;  // parts inside, joined where they touch [mm]
    for (std::size_t i = 1; i < at.size(); ++i) {
      const double a = x_at(at[i - 1]), b = x_at(at[i]);
      if (!t.region.inside({(a + b) / 2, y})) continue;
      if (!row.empty() && a - row.back().second < kShortest)
        row.back().second = b;
      else
        row.emplace_back(a, b);
    }
    std::erase_if(row, [](const auto& part) { return part.second - part.first < kShortest; });
    const bool backwards = std::llround(k) % 2 != 0;
    if (backwards) std::reverse(row.begin(), row.end());
    for (auto [a, b] : row) {
      if (backwards) std::swap(a, b);
      lines.push_back({{{a, y}, {b, y}}});
      lines.back().layer = area.layer;
      lines.back().colour = area.colour;
    }
  }
  return lines;
}

// Joins one set's lines to strokes that the pen draws in one go: from the end of a line to an end
// in a row beside it, where the way between them stays in the area. Ends stand back by `inset`, so
// that the ink of a join does, too.
std::vector<Stroke> flowing(std::vector<Stroke> lines, const AreaInFrame& t, double spacing,
                            double inset) {
  std::map<std::int64_t, std::vector<std::size_t>> rows;
  const auto row_of = [&](const Stroke& line) {
    return std::llround(line.points[0].y() / spacing - 0.5);
  };
  for (std::size_t i = 0; i < lines.size(); ++i) {
    rows[row_of(lines[i])].push_back(i);
    Vector2d &a = lines[i].points[0], &b = lines[i].points[1];
    const Vector2d step = std::min(inset / (b - a).norm(), 0.25) * (b - a);
    a += step, b -= step;
  }
  std::vector<double> crossings;
  const auto stays_inside = [&](const Vector2d& a, const Vector2d& b) {
    crossings.clear();
    t.region.crossings(a, b, crossings);
    return crossings.empty() && t.region.inside((a + b) / 2);
  };
  std::vector<Stroke> strokes;
  std::vector<char> used(lines.size(), false);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (used[i]) continue;
    used[i] = true;
    strokes.push_back(lines[i]);
    std::vector<Vector2d>& points = strokes.back().points;
    for (std::int64_t row = row_of(lines[i]);;) {
      double nearest = INFINITY;
      std::size_t next = 0;
      bool turned = false;
      std::int64_t there = row;
      for (const std::int64_t beside : {row - 1, row + 1}) {
        const auto found = rows.find(beside);
        if (found == rows.end()) continue;
        for (const std::size_t k : found->second) {
          for (const bool at_end : {false, true}) {
            const double way = (lines[k].points[at_end] - points.back()).norm();
            if (used[k] || way >= nearest || !stays_inside(points.back(), lines[k].points[at_end]))
              continue;
            nearest = way, next = k, turned = at_end, there = beside;
          }
        }
      }
      if (nearest == INFINITY) break;
      used[next] = true;
      points.push_back(lines[next].points[turned]);
      points.push_back(lines[next].points[!turned]);
      row = there;
    }
  }
  return strokes;
}

// Of the sets of lines; none without hatching.
std::vector<HatchFrame> frames_of(const HatchSettings& settings, double scale,
                                  const SurfaceDistances& on_surface,
                                  const Eigen::AlignedBox2d& box) {
  require_in_range("hatch", HatchSettings::Limits::spacing, settings.spacing_mm);
  require_in_range("hatch", HatchSettings::Limits::angle, settings.angle_deg);
  require_in_range("the hatch's scale", scale, Range::positive(), "");
  std::vector<HatchFrame> frames;
  if (settings.spacing_mm == 0 || box.isEmpty()) return frames;
  for (int set = 0; set < (settings.cross ? 2 : 1); ++set)
    frames.emplace_back((settings.angle_deg + 90.0 * set) * std::numbers::pi / 180, on_surface, box,
                        kBend / scale);
  return frames;
}

std::vector<Stroke> hatch(const Area& area, const std::vector<HatchFrame>& frames,
                          const HatchSettings& settings, double scale, bool joined) {
  std::vector<Stroke> strokes;
  const double spacing = settings.spacing_mm / scale,
               inset = std::min(settings.spacing_mm / 2, kInset) / scale;
  for (const HatchFrame& frame : frames) {
    const AreaInFrame t = in_frame(frame, area);
    std::vector<Stroke> lines = set_of_lines(t, area, spacing);
    if (joined) lines = flowing(std::move(lines), t, spacing, inset);
    for (Stroke& line : lines) line.points = frame.line_to_page(line.points);
    strokes.insert(strokes.end(), lines.begin(), lines.end());
  }
  return strokes;
}

}  // namespace

std::vector<Stroke> hatch_strokes(const Area& area, const HatchSettings& settings, double scale) {
  const auto frames = frames_of(settings, scale, {}, outlines_box(area.outlines));
  return hatch(area, frames, settings, scale, true);
}

std::vector<Stroke> hatch_lines(const Area& area, const HatchSettings& settings, double scale,
                                const SurfaceDistances& on_surface) {
  const auto frames = frames_of(settings, scale, on_surface, outlines_box(area.outlines));
  return hatch(area, frames, settings, scale, false);
}

void drop_edges(Artwork& artwork) {
  std::erase_if(artwork.strokes, [](const Stroke& stroke) { return stroke.edge; });
}

void apply_hatch(Artwork& artwork, const HatchSettings& settings, double scale,
                 const SurfaceDistances& on_surface) {
  if (!settings.outline) drop_edges(artwork);
  Eigen::AlignedBox2d box;
  for (const Area& area : artwork.areas) box.extend(outlines_box(area.outlines));
  const std::vector<HatchFrame> frames = frames_of(settings, scale, on_surface, box);
  std::vector<std::vector<Stroke>> lines(artwork.layers.size());
  for (const Area& area : artwork.areas) {
    const std::vector<Stroke> of_area = hatch(area, frames, settings, scale, true);
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

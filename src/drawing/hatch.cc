#include "impedraw/drawing/hatch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/drawing/polyline.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

template <class Map>
std::vector<Vector2d> in_pieces(const std::vector<Vector2d>& line, double longest, const Map& map) {
  std::vector<Vector2d> points = {map(line[0])};
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vector2d a = line[i - 1], way = line[i] - a;
    const int pieces = longest > 0.0 ? 1 + static_cast<int>(way.norm() / longest) : 1;
    for (int k = 1; k < pieces; ++k) points.push_back(map(a + way * k / pieces));
    points.push_back(map(line[i]));
  }
  return points;
}

}  // namespace

HatchFrame::HatchFrame(double angle, const SurfaceDistances& distances,
                       const Eigen::AlignedBox2d& box, double step)
    : along_(std::cos(angle), -std::sin(angle)), across_(std::sin(angle), std::cos(angle)) {
  if (!distances) return;
  const SurfaceDistance distance = distances(across_);
  Eigen::AlignedBox2d turned;
  for (int corner = 0; corner < 4; ++corner)
    turned.extend(to_H(box.corner(static_cast<Eigen::AlignedBox2d::CornerType>(corner))));
  step_ = step;
  low_ = turned.min();
  columns_ = static_cast<std::size_t>(turned.sizes().x() / step) + 2;
  rows_ = static_cast<std::size_t>(turned.sizes().y() / step) + 2;
  for (std::size_t i = 0; i < columns_; ++i)
    for (std::size_t j = 0; j < rows_; ++j) {
      constexpr double kLeastRise = 0.1;  // as a share of the step
      const Vector2d p = low_ + step * Vector2d(static_cast<double>(i), static_cast<double>(j));
      const double there = distance(p.x() * along_ + p.y() * across_);
      table_.push_back(j == 0 ? there : std::max(there, table_.back() + kLeastRise * step));
    }
}

double HatchFrame::sample(double x, std::size_t row) const {
  const double at = std::clamp((x - low_.x()) / step_, 0.0, static_cast<double>(columns_ - 1));
  const std::size_t i = std::min(columns_ - 2, static_cast<std::size_t>(at)), k = i * rows_ + row;
  return table_[k] + (at - static_cast<double>(i)) * (table_[k + rows_] - table_[k]);
}

Vector2d HatchFrame::to_H(const Vector2d& page_mm) const {
  const Vector2d p(along_.dot(page_mm), across_.dot(page_mm));
  if (step_ == 0.0) return p;
  const double at = (p.y() - low_.y()) / step_;
  const auto row = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(rows_ - 2)));
  const double below = sample(p.x(), row);
  return {p.x(), below + (at - static_cast<double>(row)) * (sample(p.x(), row + 1) - below)};
}

Vector2d HatchFrame::to_page(const Vector2d& p_H) const {
  if (step_ == 0.0) return p_H.x() * along_ + p_H.y() * across_;
  std::size_t row = 0, end = rows_ - 1;  // y_H lies between their samples, but for the ends
  while (end - row > 1) {
    const std::size_t middle = (row + end) / 2;
    (sample(p_H.x(), middle) <= p_H.y() ? row : end) = middle;
  }
  const double below = sample(p_H.x(), row),
               share = (p_H.y() - below) / (sample(p_H.x(), row + 1) - below);
  return p_H.x() * along_ + (low_.y() + step_ * (static_cast<double>(row) + share)) * across_;
}

std::vector<Vector2d> HatchFrame::outline_to_H(std::vector<Vector2d> page_mm) const {
  if (step_ > 0.0) page_mm.push_back(Vector2d(page_mm.front()));
  return in_pieces(page_mm, step_, [this](const Vector2d& p) { return to_H(p); });
}

std::vector<Vector2d> HatchFrame::line_to_page(const std::vector<Vector2d>& line_H) const {
  return in_pieces(line_H, step_, [this](const Vector2d& p) { return to_page(p); });
}

namespace {

constexpr double kMostRows = 100'000;
constexpr double kDetail = 0.02;  // of an outline that its insets do without [spacings]
constexpr double kChords = 1e-3;  // a circle's chords lie within it, of the spacing

HatchLine circle(const Vector2d& middle, double radius, double spacing, std::int64_t row) {
  const double chords =
      std::max(12.0, std::ceil(std::numbers::pi * std::sqrt(radius / (2 * kChords * spacing))));
  HatchLine line{{}, row};
  for (double i = 0; i < chords; ++i) {
    const double at = 2 * std::numbers::pi * i / chords;
    line.points.push_back(middle + radius * Vector2d(std::cos(at), std::sin(at)));
  }
  line.points.push_back(Vector2d(line.points.front()));
  return line;
}

std::vector<Vector2d> without_detail(const std::vector<Vector2d>& outline, double tolerance) {
  std::vector<Vector2d> kept;
  for (const std::size_t i : simplified(outline, tolerance)) kept.push_back(outline[i]);
  return kept;
}

}  // namespace

double require_few_rows(double farthest, double spacing) {
  const double rows = farthest / spacing;
  if (rows > kMostRows) {
    throw InputError(
        fmt::format("hatch: an area of {:.4g} mm across would take {:.3g} lines {:.3g} mm apart on "
                    "the page; at most {:.0e} are drawn",
                    farthest, rows, spacing, kMostRows));
  }
  return rows;
}

std::vector<HatchLine> page_rings(const Outlines& region, HatchStyle style, double spacing) {
  std::vector<HatchLine> lines;
  const Eigen::AlignedBox2d box = outlines_box(region);
  if (box.isEmpty()) return lines;
  if (style == HatchStyle::concentric) {
    double farthest = 0;
    for (const auto& outline : region)
      for (const Vector2d& p : outline) farthest = std::max(farthest, (p - box.center()).norm());
    const double rows = require_few_rows(farthest, spacing);
    for (double k = 0; k + 0.5 < rows; ++k)
      lines.push_back(
          circle(box.center(), (k + 0.5) * spacing, spacing, static_cast<std::int64_t>(k)));
    return lines;
  }
  require_few_rows(box.sizes().minCoeff() / 2, spacing);
  const RegionMath math(box);
  Outlines coarse = region;  // what is much finer than the spacing would only take time
  for (auto& outline : coarse) outline = without_detail(outline, kDetail * spacing);
  Outlines inset = math.inset(math.united(coarse), spacing / 2);
  for (std::int64_t row = 0; !inset.empty(); ++row, inset = math.inset(inset, spacing)) {
    for (const auto& outline : inset) {
      lines.push_back({outline, row});
      lines.back().points.push_back(Vector2d(outline.front()));
    }
  }
  return lines;
}

namespace {

constexpr double kShortestPart = 1e-5;  // [mm]
constexpr double kNearlyFull = 0.75;    // tone of an even area from which it has all lines
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
      if (!row.empty() && a - row.back().second < kShortestPart)
        row.back().second = b;
      else
        row.emplace_back(a, b);
    }
    std::erase_if(row, [](const auto& part) { return part.second - part.first < kShortestPart; });
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
  const double full = settings.spacing_mm / scale,
               spacing = even && area.tone < kNearlyFull ? full / area.tone : full,
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

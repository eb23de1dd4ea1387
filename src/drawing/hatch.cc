#include "impedraw/drawing/hatch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>

#include <fmt/core.h>
#include <polyclipping/clipper.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/drawing/regions.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
namespace cl = ClipperLib;
constexpr double kMostLines = 100'000;
// Clipper's integer range across half an area; beyond 2^30 it needs wider arithmetic
constexpr double kFineness = 5e8;
constexpr double kShortest = 1e-5;  // [mm]
constexpr double kInset = 0.25;  // of joined lines from the outline: half a pen [mm on the canvas]

// One set of lines. They are vertical in the frame H, because Clipper treats horizontal edges
// specially: y_H along the lines, x_H across.
void add_lines(const Area& area, double spacing, double angle, std::vector<Stroke>& result) {
  const Vector2d along(std::cos(angle), -std::sin(angle)), across(std::sin(angle), std::cos(angle));
  Eigen::AlignedBox2d box;
  for (const auto& outline : area.outlines) {
    for (const Vector2d& p : outline) box.extend(Vector2d(across.dot(p), along.dot(p)));
  }
  if (box.isEmpty()) return;
  const double first = std::ceil(box.min().x() / spacing - 0.5),
               last = std::floor(box.max().x() / spacing - 0.5);
  if (last - first > kMostLines) {
    throw InputError(
        fmt::format("hatch: an area of {:.4g} mm across would take {:.3g} lines {:.3g} mm apart on "
                    "the page; at most {:.0e} "
                    "are drawn",
                    box.sizes().x(), last - first, spacing, kMostLines));
  }
  if (last < first) return;
  const Vector2d centre = box.center();
  const double fineness = kFineness / std::max(box.sizes().maxCoeff() / 2 + spacing, 1e-3);
  const auto to_clipper = [&](const Vector2d& h) {
    return cl::IntPoint(std::llround((h.x() - centre.x()) * fineness),
                        std::llround((h.y() - centre.y()) * fineness));
  };

  cl::Clipper clipper;
  for (const auto& outline : area.outlines) {
    cl::Path path;
    for (const Vector2d& p : outline) path.push_back(to_clipper({across.dot(p), along.dot(p)}));
    clipper.AddPath(path, cl::ptClip, true);
  }
  const double below = box.min().y() - spacing / 2, above = box.max().y() + spacing / 2;
  for (double k = first; k <= last; ++k) {
    const double x = (k + 0.5) * spacing;
    clipper.AddPath({to_clipper({x, below}), to_clipper({x, above})}, cl::ptSubject, false);
  }
  const cl::PolyFillType rule = area.even_odd ? cl::pftEvenOdd : cl::pftNonZero;
  cl::PolyTree inside;
  if (!clipper.Execute(cl::ctIntersection, inside, rule, rule))
    throw InputError("hatch: an area could not be clipped");
  cl::Paths pieces;
  cl::OpenPathsFromPolyTree(inside, pieces);

  struct Piece {
    std::int64_t k;
    double from, to;
  };
  std::vector<Piece> rows;
  for (const cl::Path& piece : pieces) {
    const auto [low, high] = std::minmax_element(
        piece.begin(), piece.end(), [](const auto& a, const auto& b) { return a.Y < b.Y; });
    const double x = centre.x() + static_cast<double>(low->X) / fineness;
    rows.push_back({std::llround(x / spacing - 0.5),
                    centre.y() + static_cast<double>(low->Y) / fineness,
                    centre.y() + static_cast<double>(high->Y) / fineness});
  }
  std::sort(rows.begin(), rows.end(), [](const Piece& a, const Piece& b) {
    return a.k != b.k ? a.k < b.k : a.from < b.from;
  });
  // Joins pieces that touch: Clipper may cut a line where a corner of the outline lies on it.
  std::vector<Piece> whole;
  for (const Piece& piece : rows) {
    const bool touches =
        !whole.empty() && whole.back().k == piece.k && piece.from - whole.back().to < kShortest;
    if (touches)
      whole.back().to = std::max(whole.back().to, piece.to);
    else
      whole.push_back(piece);
  }
  for (std::size_t i = 0; i < whole.size();) {
    std::size_t end = i;
    while (end < whole.size() && whole[end].k == whole[i].k) ++end;
    std::vector<Stroke> row;
    for (; i < end; ++i) {
      if (whole[i].to - whole[i].from < kShortest) continue;
      const Vector2d at = (static_cast<double>(whole[i].k) + 0.5) * spacing * across;
      row.push_back({{at + whole[i].from * along, at + whole[i].to * along}});
      row.back().layer = area.layer;
      row.back().colour = area.colour;
    }
    if (whole[end - 1].k % 2 != 0) {
      std::reverse(row.begin(), row.end());
      for (Stroke& stroke : row) std::swap(stroke.points[0], stroke.points[1]);
    }
    result.insert(result.end(), row.begin(), row.end());
  }
}

// Joins one set's lines to strokes that the pen draws in one go: from the end of a line to an end
// in a row beside it, where the way between them stays in the area. Ends stand back by `inset`, so
// that the ink of a join does, too.
std::vector<Stroke> flowing(std::vector<Stroke> lines, const Area& area, const Vector2d& across,
                            double spacing, double inset) {
  const RegionIndex region(RegionMath(outlines_box(area.outlines)).region(area));
  std::map<std::int64_t, std::vector<std::size_t>> rows;
  const auto row_of = [&](const Stroke& line) {
    return std::llround(across.dot(line.points[0]) / spacing - 0.5);
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
    region.crossings(a, b, crossings);
    return crossings.empty() && region.inside((a + b) / 2);
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

}  // namespace

std::vector<Stroke> hatch_strokes(const Area& area, const HatchSettings& settings, double scale) {
  std::vector<Stroke> strokes;
  HatchSettings set = settings;
  set.cross = false;
  for (const double turn : settings.cross ? std::vector{0.0, 90.0} : std::vector{0.0}) {
    const double angle = (settings.angle_deg + turn) * std::numbers::pi / 180;
    std::vector<Stroke> lines;
    if (settings.spacing_mm > 0 && turn > 0)
      add_lines(area, settings.spacing_mm / scale, angle, lines);
    else
      lines = hatch_lines(area, set, scale);
    if (lines.empty()) continue;
    lines = flowing(std::move(lines), area, {std::sin(angle), std::cos(angle)},
                    settings.spacing_mm / scale, std::min(settings.spacing_mm / 2, kInset) / scale);
    strokes.insert(strokes.end(), lines.begin(), lines.end());
  }
  return strokes;
}

std::vector<Stroke> hatch_lines(const Area& area, const HatchSettings& settings, double scale) {
  require_in_range("hatch", HatchSettings::Limits::spacing, settings.spacing_mm);
  require_in_range("hatch", HatchSettings::Limits::angle, settings.angle_deg);
  require_in_range("the hatch's scale", scale, Range::positive(), "");
  std::vector<Stroke> lines;
  if (settings.spacing_mm == 0) return lines;
  const double angle = settings.angle_deg * std::numbers::pi / 180;
  add_lines(area, settings.spacing_mm / scale, angle, lines);
  if (settings.cross)
    add_lines(area, settings.spacing_mm / scale, angle + std::numbers::pi / 2, lines);
  return lines;
}

void drop_edges(Artwork& artwork) {
  std::erase_if(artwork.strokes, [](const Stroke& stroke) { return stroke.edge; });
}

void apply_hatch(Artwork& artwork, const HatchSettings& settings, double scale) {
  if (!settings.outline) drop_edges(artwork);
  std::vector<std::vector<Stroke>> lines(artwork.layers.size());
  for (const Area& area : artwork.areas) {
    const std::vector<Stroke> of_area = hatch_strokes(area, settings, scale);
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

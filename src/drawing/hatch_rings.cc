#include "impedraw/drawing/hatch_rings.h"

#include <cmath>
#include <numbers>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/polyline.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
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

}  // namespace impedraw

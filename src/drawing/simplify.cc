#include "impedraw/drawing/simplify.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/polyline.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr double kSamePress = 0.01;

void require_length(const char* name, double value) {
  if (!(value >= 0) || !std::isfinite(value))
    throw InputError(fmt::format("{}: {} mm; must be a number ≥ 0", name, value));
}

// The vertices that simplified() keeps, and those that the press needs: between them it changes
// evenly with the length, to within kSamePress of its range.
std::vector<std::size_t> kept_points(const std::vector<Vector2d>& line,
                                     const std::vector<double>& press, double tolerance_mm) {
  std::vector<std::size_t> kept = simplified(line, tolerance_mm);
  if (press.empty()) return kept;
  const auto [low, high] = std::minmax_element(press.begin(), press.end());
  if (*low == *high) return kept;
  std::vector<Vector2d> graph{{0, press[0]}};  // press over length
  for (std::size_t i = 1; i < line.size(); ++i)
    graph.emplace_back(graph.back().x() + (line[i] - line[i - 1]).norm(), press[i]);
  // Scaled so that the tolerance is far below any length: what counts is the way across.
  const double scale = 1 / (kSamePress * (*high - *low));
  for (Vector2d& p : graph) p = {1e6 * scale * p.x() / graph.back().x(), scale * p.y()};
  const std::vector<std::size_t> bends = simplified(graph, 1.0);
  std::vector<std::size_t> both;
  std::set_union(kept.begin(), kept.end(), bends.begin(), bends.end(), std::back_inserter(both));
  return both;
}

}  // namespace

Stroke simplified(const Stroke& stroke, double tolerance_mm) {
  require_length("simplification's tolerance", tolerance_mm);
  const std::vector<Vector2d>& p = stroke.points;
  if (p.size() < 3 || tolerance_mm == 0) return stroke;
  // A closed stroke is cut in two at the point farthest from its start; otherwise nothing would be
  // left of a small one.
  std::size_t cut = p.size() - 1;
  if (stroke.closed) {
    const auto nearer = [&](const Vector2d& a, const Vector2d& b) {
      return (a - p[0]).norm() < (b - p[0]).norm();
    };
    cut = static_cast<std::size_t>(std::max_element(p.begin(), p.end(), nearer) - p.begin());
  }
  Stroke result = like(stroke, {}, stroke.closed);
  for (const auto& [from, to] : {std::pair(std::size_t{0}, cut), std::pair(cut, p.size() - 1)}) {
    if (from == to) continue;
    const std::vector<Vector2d> part(p.begin() + from, p.begin() + to + 1);
    const std::vector<double> press(
        stroke.press.empty() ? stroke.press.end() : stroke.press.begin() + from,
        stroke.press.empty() ? stroke.press.end() : stroke.press.begin() + to + 1);
    for (const std::size_t i : kept_points(part, press, tolerance_mm)) {
      if (i == 0 && from > 0) continue;
      result.points.push_back(part[i]);
      if (!press.empty()) result.press.push_back(press[i]);
    }
  }
  return result;
}

}  // namespace impedraw

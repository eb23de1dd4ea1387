#include "impedraw/drawing/simplify.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>
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

// The press at each point, also of a stroke that has one width.
std::vector<double> press_of(const Stroke& stroke) {
  return stroke.press.empty() ? std::vector<double>(stroke.points.size(), stroke.width)
                              : stroke.press;
}

// True if the line is as heavy at those ends, or tells it in the same way.
bool same_measure(const Stroke& a, const Stroke& b) {
  return a.by_force == b.by_force &&
         (a.width > 0 || !a.press.empty()) == (b.width > 0 || !b.press.empty());
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

std::vector<Stroke> joined(const std::vector<Stroke>& strokes, double gap_mm) {
  require_length("the gap for joining", gap_mm);
  const int count = static_cast<int>(strokes.size());
  const auto end = [&](int e) -> const Vector2d& {
    return e % 2 ? strokes[e / 2].points.back() : strokes[e / 2].points.front();
  };
  const auto open = [&](int s) {
    return !strokes[s].closed && strokes[s].points.size() > 1 && strokes[s].dash < 0;
  };

  // Sorts the ends into cells as large as the gap, so that partners lie in neighbouring cells.
  const double cell = std::max(gap_mm, 1e-6);
  const auto cell_of = [&](const Vector2d& p) {
    return std::pair<long, long>(std::lround(p.x() / cell), std::lround(p.y() / cell));
  };
  std::map<std::pair<long, long>, std::vector<int>> cells;
  for (int e = 0; e < 2 * count; ++e) {
    if (open(e / 2)) cells[cell_of(end(e))].push_back(e);
  }
  std::vector<std::tuple<double, int, int>> links;
  for (int a = 0; a < 2 * count; ++a) {
    if (!open(a / 2)) continue;
    const auto [x, y] = cell_of(end(a));
    for (long dx = -1; dx <= 1; ++dx) {
      for (long dy = -1; dy <= 1; ++dy) {
        const auto found = cells.find({x + dx, y + dy});
        if (found == cells.end()) continue;
        for (const int b : found->second) {
          const double length = (end(a) - end(b)).norm();
          if (a < b && length <= gap_mm && strokes[a / 2].layer == strokes[b / 2].layer &&
              same_measure(strokes[a / 2], strokes[b / 2]))
            links.emplace_back(length, a, b);
        }
      }
    }
  }
  std::sort(links.begin(), links.end());

  std::vector<int> partner(2 * count, -1),
      far(2 * count);  // for a free end, the other free end of its chain
  for (int e = 0; e < 2 * count; ++e) far[e] = e ^ 1;
  for (const auto& [length, a, b] : links) {
    if (partner[a] >= 0 || partner[b] >= 0 || far[a] == b) continue;
    partner[a] = b;
    partner[b] = a;
    const int out_a = far[a], out_b = far[b];
    far[out_a] = out_b;
    far[out_b] = out_a;
  }

  std::vector<Stroke> result;
  std::vector<char> used(count, false);
  for (int s = 0; s < count; ++s) {
    if (used[s]) continue;
    // Go back to the chain's start, so that its first part keeps its direction if possible.
    int e = 2 * s;
    while (partner[e] >= 0) e = partner[e] ^ 1;
    Stroke stroke = like(strokes[s], {}, strokes[s].closed);
    bool even = true;  // one width all along
    for (; e >= 0; e = partner[e ^ 1]) {
      used[e / 2] = true;
      std::vector<Vector2d> part = strokes[e / 2].points;
      std::vector<double> press = press_of(strokes[e / 2]);
      even = even && strokes[e / 2].press.empty() && strokes[e / 2].width == strokes[s].width;
      if (e % 2) {
        std::reverse(part.begin(), part.end());
        std::reverse(press.begin(), press.end());
      }
      const bool touches = !stroke.points.empty() && stroke.points.back() == part.front();
      stroke.points.insert(stroke.points.end(), part.begin() + touches, part.end());
      stroke.press.insert(stroke.press.end(), press.begin() + touches, press.end());
    }
    if (even) stroke.press.clear();
    stroke.closed = stroke.points.size() > 2 && stroke.points.front() == stroke.points.back();
    result.push_back(std::move(stroke));
  }
  return result;
}

}  // namespace impedraw

#include "impedraw/drawing/simplify.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/order.h"
#include "impedraw/drawing/polyline.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

bool alike(const Stroke& a, const Stroke& b) {
  return a.layer == b.layer && a.dash == b.dash && a.edge == b.edge && a.colour == b.colour &&
         a.width == b.width && a.press.empty() == b.press.empty() && a.by_force == b.by_force;
}

class Joiner {
 public:
  explicit Joiner(std::vector<Stroke>& strokes) : strokes_(strokes), taken_(strokes.size(), 0) {
    for (std::size_t s = 0; s < strokes.size(); ++s) {
      if (strokes[s].closed || strokes[s].points.size() < 2) continue;
      for (const bool last : {false, true}) ends_[cell(end(s, last))].push_back({s, last});
    }
  }

  std::vector<Stroke> all() {
    std::vector<Stroke> lines;
    for (std::size_t s = 0; s < strokes_.size(); ++s) {
      if (std::exchange(taken_[s], 1)) continue;
      Stroke line = std::move(strokes_[s]);
      if (!line.closed && line.points.size() > 1) {
        extend(line);
        reverse(line);
        extend(line);
        reverse(line);
      }
      lines.push_back(std::move(line));
    }
    return lines;
  }

 private:
  using Cell = std::pair<long, long>;
  struct End {
    std::size_t stroke;
    bool last;
  };

  static Cell cell(const Vector2d& p) {
    return {std::lround(p.x() / kJoined), std::lround(p.y() / kJoined)};
  }
  const Vector2d& end(std::size_t s, bool last) const {
    return last ? strokes_[s].points.back() : strokes_[s].points.front();
  }

  // The end that `line` goes on at; null if there is none.
  const End* next(const Stroke& line) const {
    const Vector2d p = line.points.back(), before = *(line.points.end() - 2);
    const auto [i, j] = cell(p);
    const End* best = nullptr;
    double most = -2.0;
    for (long x = i - 1; x <= i + 1; ++x)
      for (long y = j - 1; y <= j + 1; ++y) {
        const auto found = ends_.find({x, y});
        if (found == ends_.end()) continue;
        for (const End& e : found->second) {
          if (taken_[e.stroke] || !alike(line, strokes_[e.stroke])) continue;
          const std::vector<Vector2d>& q = strokes_[e.stroke].points;
          if ((end(e.stroke, e.last) - p).norm() > kJoined) continue;
          const Vector2d on = e.last ? *(q.end() - 2) - q.back() : q[1] - q[0];
          const double cosine = on.normalized().dot((p - before).normalized());
          if (cosine <= most) continue;
          most = cosine;
          best = &e;
        }
      }
    return best;
  }

  void extend(Stroke& line) {
    while (const End* found = next(line)) {
      taken_[found->stroke] = 1;
      Stroke& piece = strokes_[found->stroke];
      if (found->last) reverse(piece);
      const auto same = static_cast<std::ptrdiff_t>(piece.points.front() == line.points.back());
      line.points.insert(line.points.end(), piece.points.begin() + same, piece.points.end());
      if (!line.press.empty())
        line.press.insert(line.press.end(), piece.press.begin() + same, piece.press.end());
      piece = {};
    }
    line.closed = line.points.front() == line.points.back() && line.press.empty();
  }

  std::vector<Stroke>& strokes_;
  std::vector<char> taken_;
  std::map<Cell, std::vector<End>> ends_;
};

}  // namespace

std::vector<Stroke> joined(std::vector<Stroke> strokes) { return Joiner(strokes).all(); }

namespace {

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

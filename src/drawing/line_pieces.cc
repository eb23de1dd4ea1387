#include "impedraw/drawing/line_pieces.h"

#include <algorithm>

namespace impedraw {

using Eigen::Vector2d;

std::vector<LinePiece> visible_pieces(const std::vector<Vector2d>& line, double hair,
                                      const std::vector<const RegionIndex*>& indices,
                                      const std::function<bool(const Spot&)>& visible) {
  std::vector<LinePiece> pieces;
  if (line.size() == 1 && visible({line[0], Vector2d::Zero()})) pieces.push_back({line, 0, 0});
  bool on = false;
  double before = 0;
  std::vector<double> at;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vector2d &a = line[i - 1], &b = line[i], along = b - a;
    const double length = along.norm();
    const Vector2d side = hair / length * Vector2d(-along.y(), along.x());
    at = {0};
    for (const RegionIndex* index : indices) {
      index->crossings(a + side, b + side, at);
      index->crossings(a - side, b - side, at);
    }
    std::sort(at.begin(), at.end());
    at.push_back(1);
    for (std::size_t k = 1; k < at.size(); ++k) {
      if (at[k] <= at[k - 1]) continue;
      const bool shows = visible({a + (at[k] + at[k - 1]) / 2 * along, side});
      const Vector2d from = at[k - 1] == 0 ? a : Vector2d(a + at[k - 1] * along);
      const Vector2d to = at[k] == 1 ? b : Vector2d(a + at[k] * along);
      if (shows && !on) pieces.push_back({{from}, before + at[k - 1] * length, 0});
      // Within a segment, parts that follow each other are one.
      const bool goes_on = shows && on && at[k - 1] != 0;
      if (goes_on) pieces.back().points.back() = to;
      if (shows && !goes_on) pieces.back().points.push_back(to);
      if (shows) pieces.back().length += (at[k] - at[k - 1]) * length;
      on = shows;
    }
    before += length;
  }
  return pieces;
}

std::vector<Vector2d> line_part(const std::vector<Vector2d>& line, double from, double to) {
  std::vector<Vector2d> part;
  double before = 0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vector2d &a = line[i - 1], &b = line[i];
    const double after = before + (b - a).norm();
    const auto at = [&](double s) {
      return Vector2d(a + (s - before) / (after - before) * (b - a));
    };
    if (after > from && part.empty()) part.push_back(from > before ? at(from) : a);
    if (after > from && before < to) part.push_back(after > to ? at(to) : b);
    before = after;
  }
  return part;
}

bool is_stroke_end(const Vector2d& a, const Vector2d& b, const std::vector<Vector2d>& line,
                   double width) {
  const auto at = [&](const Vector2d& end, const Vector2d& before) {
    const Vector2d along = (end - before).normalized();
    const auto on = [&](const Vector2d& p) {
      return std::abs((p - end).dot(along)) < 1e-3 * width && (p - end).norm() < 0.501 * width;
    };
    return on(a) && on(b);
  };
  return at(line.front(), line[1]) || at(line.back(), line[line.size() - 2]);
}

}  // namespace impedraw

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

std::vector<LinePiece> pieces_where(
    const std::vector<Vector2d>& line, double step,
    const std::function<bool(const Vector2d&, const Vector2d&)>& is_seen) {
  std::vector<double> ends{0};  // of the segments, along the line
  for (std::size_t i = 1; i < line.size(); ++i)
    ends.push_back(ends.back() + (line[i] - line[i - 1]).norm());
  const double whole = ends.back();
  if (!(whole > 0)) return {{line, 0, whole}};
  const auto seen_at = [&](double s) {
    const auto end = std::upper_bound(ends.begin() + 1, ends.end() - 1, s) - ends.begin();
    const Vector2d along = (line[end] - line[end - 1]) / (ends[end] - ends[end - 1]);
    return is_seen(line[end - 1] + (s - ends[end - 1]) * along, along);
  };
  const double count = std::ceil(std::max(whole / step, 3.0)), each = whole / count;
  std::vector<bool> seen;
  for (double i = 0; i < count; ++i) seen.push_back(seen_at((i + 0.5) * each));
  for (std::size_t i = 1; i + 1 < seen.size(); ++i) {  // a corner, or where others cross
    if (seen[i - 1] == seen[i + 1]) seen[i] = seen[i - 1];
  }
  std::vector<double> changes{0};
  for (std::size_t i = 1; i < seen.size(); ++i) {
    if (seen[i] == seen[i - 1]) continue;
    double from = (static_cast<double>(i) - 0.5) * each, to = from + each;
    while (to - from > each / 1000) {
      const double middle = (from + to) / 2;
      (seen_at(middle) == seen[i] ? to : from) = middle;
    }
    changes.push_back(to);
  }
  changes.push_back(whole);
  std::vector<LinePiece> pieces;
  for (std::size_t i = seen[0] ? 0 : 1; i + 1 < changes.size(); i += 2)
    pieces.push_back({changes.size() == 2 ? line : line_part(line, changes[i], changes[i + 1]),
                      changes[i], changes[i + 1] - changes[i]});
  return pieces;
}

}  // namespace impedraw

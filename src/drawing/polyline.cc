#include "impedraw/drawing/polyline.h"

#include <algorithm>
#include <cmath>

#include "impedraw/common/cross.h"

namespace impedraw {

using Eigen::Vector2d;

double length(const std::vector<Vector2d>& line) {
  double sum = 0;
  for (std::size_t i = 1; i < line.size(); ++i) sum += (line[i] - line[i - 1]).norm();
  return sum;
}

Vector2d nearest_on_segment(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
  const Vector2d along = b - a;
  const double share = (p - a).dot(along) / std::max(along.squaredNorm(), 1e-30);
  return a + std::clamp(share, 0.0, 1.0) * along;
}

double distance(const Vector2d& p, const std::vector<Vector2d>& line, std::size_t first,
                std::size_t last) {
  double nearest = (p - line[first]).squaredNorm();
  for (std::size_t i = first + 1; i <= last; ++i) {
    const Vector2d side = line[i] - line[i - 1], to = p - line[i - 1];
    const double squared = side.squaredNorm();
    const double s = squared > 0 ? std::clamp(to.dot(side) / squared, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (to - s * side).squaredNorm());
  }
  return std::sqrt(nearest);
}

std::vector<std::size_t> simplified(const std::vector<Vector2d>& line, double tolerance) {
  std::vector<char> kept(line.size(), 0);
  kept.front() = kept.back() = 1;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, line.size() - 1}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    const std::vector<Vector2d> chord{line[first], line[last]};
    double farthest = tolerance;
    std::size_t at = first;
    for (std::size_t i = first + 1; i < last; ++i) {
      const double d = distance(line[i], chord, 0, 1);
      if (d > farthest) farthest = d, at = i;
    }
    if (at == first) continue;
    kept[at] = 1;
    open.push_back({first, at});
    open.push_back({at, last});
  }
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (kept[i]) indices.push_back(i);
  }
  return indices;
}

double turn_at(const std::vector<Vector2d>& line, std::size_t i) {
  const Vector2d a = line[i] - line[i - 1], b = line[i + 1] - line[i];
  return std::atan2(cross(a, b), a.dot(b));
}

std::vector<std::size_t> corners(const std::vector<Vector2d>& line, double angle) {
  std::vector<std::size_t> found;
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    if (std::abs(turn_at(line, i)) > angle) found.push_back(i);
  }
  return found;
}

}  // namespace impedraw

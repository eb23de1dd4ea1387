// What the drawing tests measure on polylines.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include <Eigen/Core>

namespace impedraw::lines {

using Eigen::Vector2d;

inline double length(const std::vector<Vector2d>& line) {
  double sum = 0;
  for (std::size_t i = 1; i < line.size(); ++i) sum += (line[i] - line[i - 1]).norm();
  return sum;
}

inline double distance(const Vector2d& p, const std::vector<Vector2d>& line) {
  double nearest = (p - line.front()).norm();
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vector2d side = line[i] - line[i - 1];
    const double s =
        std::clamp((p - line[i - 1]).dot(side) / std::max(side.squaredNorm(), 1e-300), 0.0, 1.0);
    nearest = std::min(nearest, (p - line[i - 1] - s * side).norm());
  }
  return nearest;
}

// The largest distance of f(0 … 1) to the line.
template <class Curve>
double worst(const Curve& f, const std::vector<Vector2d>& line, int samples = 2000) {
  double largest = 0;
  for (int i = 0; i <= samples; ++i)
    largest = std::max(largest, distance(f(static_cast<double>(i) / samples), line));
  return largest;
}

}  // namespace impedraw::lines

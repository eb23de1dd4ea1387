#include "impedraw/perception/recent_neighbours.h"

#include <algorithm>
#include <cmath>

namespace impedraw {

using Eigen::Vector3d;

int RecentNeighbours::nearest(const NeighbourTree& tree, const std::vector<Vector3d>& points,
                              const Vector3d& p, int k, double max_radius, int* index,
                              double* squared) noexcept {
  constexpr double kFar = 0.25;     // of the reach: beyond, the points seldom suffice
  constexpr double kFurther = 1.3;  // of max_radius
  const double moved = (p - middle_).norm();
  if (moved < kFar * reach_)
    if (const int n = among(p, moved, k, max_radius, index, squared); n >= 0) return n;
  int found[kMost];
  double distances[kMost];
  const int most = static_cast<int>(std::ceil(kSpare * k));
  middle_ = p;
  n_ = tree.nearest(p, most, kFurther * max_radius, found, distances, reach_ * reach_);
  reach_ = n_ == most ? std::sqrt(distances[n_ - 1]) : kFurther * max_radius;
  for (int i = 0; i < n_; ++i) {
    const Vector3d& q = points[static_cast<std::size_t>(found[i])];
    x_[i] = q.x(), y_[i] = q.y(), z_[i] = q.z();
    order_[i] = {distances[i], found[i], i};
  }
  if (const int n = among(p, 0.0, k, max_radius, index, squared); n >= 0) return n;
  return tree.nearest(p, k, max_radius, index, squared);  // too many are equally far
}

// −1: there may be nearer points than those that are kept.
int RecentNeighbours::among(const Vector3d& p, double moved, int k, double max_radius, int* index,
                            double* squared) noexcept {
  for (int i = 0; i < n_; ++i) {  // in order already, but for a few
    Item item = order_[i];
    const double x = x_[item.at] - p.x(), y = y_[item.at] - p.y(), z = z_[item.at] - p.z();
    item.squared = x * x + y * y + z * z;
    int to = i;
    for (; to > 0 && item.squared < order_[to - 1].squared; --to) order_[to] = order_[to - 1];
    order_[to] = item;
  }
  int n = 0;
  for (; n < std::min(k, n_) && order_[n].squared < max_radius * max_radius; ++n) {
    index[n] = order_[n].index;
    squared[n] = order_[n].squared;
  }
  const double needed = n == k ? std::sqrt(squared[k - 1]) : max_radius;
  return needed + moved < reach_ ? n : -1;
}

}  // namespace impedraw

#include "impedraw/run/touched_heights.h"

#include <algorithm>
#include <cmath>

namespace impedraw {

double TouchedHeights::level(double x, double y) const noexcept {
  double level = top_;
  for (const Eigen::Vector3d& p : points_)
    level = std::min(level, p.z() + kMargin + kSteepest * std::hypot(p.x() - x, p.y() - y));
  return level;
}

}  // namespace impedraw

#include "impedraw/perception/seen_surface.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace impedraw {
namespace {

constexpr int kDirections = 8;

}  // namespace

SeenSurface::SeenSurface(const PointCloud& cloud, double gap, double around)
    : cloud_(cloud), tree_(cloud.points), gap_(gap), around_(around) {}

bool SeenSurface::operator()(const Eigen::Vector3d& p_W) const {
  int nearest = 0;
  double squared = 0.0;
  if (tree_.nearest(p_W, 1, gap_, &nearest, &squared) == 0) return false;
  const Eigen::Vector3d& n_W = cloud_.normals[static_cast<std::size_t>(nearest)];
  if (!n_W.allFinite()) return false;
  const Eigen::Vector3d a = n_W.unitOrthogonal(), b = n_W.cross(a);
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kDirections;
    const Eigen::Vector3d way = around_ * (std::cos(angle) * a + std::sin(angle) * b);
    if (!tree_.has_within(p_W + way, gap_, 1) || !tree_.has_within(p_W + 0.5 * way, gap_, 1))
      return false;
  }
  return true;
}

}  // namespace impedraw

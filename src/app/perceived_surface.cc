#include "app/perceived_surface.h"

#include <cmath>
#include <limits>

namespace impedraw {

namespace {

double height_of_nearest_column(const PointCloud& cloud, double x, double y) {
  double nearest = std::numeric_limits<double>::infinity(), z = 0.0;
  for (const Eigen::Vector3d& p : cloud.points) {
    const double distance = std::hypot(p.x() - x, p.y() - y);
    if (distance >= nearest) continue;
    nearest = distance;
    z = p.z();
  }
  return z;
}

// The paper's neighbourhoods jump as points enter and leave, so that the steps may not shrink to nothing: what they settle within is taken.
std::optional<SurfaceSample> descend(const SurfaceEstimator& estimator, Eigen::Vector3d p) {
  constexpr double kConverged = 1e-7, kSettled = 5e-4;  // [m]
  double step = std::numeric_limits<double>::infinity();
  SurfaceEstimate estimate;
  for (int i = 0; i < 12 && std::abs(step) > kConverged; ++i) {
    estimate = estimator.estimate(p);
    if (estimate.status != SurfaceStatus::ok || estimate.n_W.z() < 0.05) return std::nullopt;
    step = estimate.distance / estimate.n_W.z();
    p.z() -= step;
  }
  if (std::abs(step) > kSettled) return std::nullopt;
  return SurfaceSample{p, estimate.n_W};
}

}  // namespace

SurfaceHeight perceived_height(const SurfaceEstimator& estimator) {
  return [&estimator, last = Eigen::Vector3d(Eigen::Vector3d::Constant(1e9))](double x, double y) mutable -> std::optional<SurfaceSample> {
    std::optional<SurfaceSample> sample;
    if (std::hypot(last.x() - x, last.y() - y) < 0.01) sample = descend(estimator, {x, y, last.z()});
    if (!sample) sample = descend(estimator, {x, y, height_of_nearest_column(estimator.cloud(), x, y)});
    if (sample) last = sample->p_W;
    return sample;
  };
}

}  // namespace impedraw

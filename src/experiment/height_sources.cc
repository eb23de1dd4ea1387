#include "impedraw/experiment/height_sources.h"

#include <cmath>
#include <limits>
#include <memory>

#include <nanoflann.hpp>

namespace impedraw {

namespace {

// The cloud in P, to find the point nearest to a line along z.
class Columns {
 public:
  Columns(const PointCloud& cloud, const Pose& X_PW) : tree_(2, *this) {
    for (const Eigen::Vector3d& p_W : cloud.points) points_.push_back(X_PW * p_W);
    tree_.buildIndex();
  }
  Columns(const Columns&) = delete;

  double height_at(double x, double y) const {
    const double at[] = {x, y};
    std::size_t nearest = 0;
    double squared = 0.0;
    return tree_.knnSearch(at, 1, &nearest, &squared) == 1 ? points_[nearest].z() : 0.0;
  }

  std::size_t kdtree_get_point_count() const { return points_.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points_[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }

 private:
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Columns>,
                                                   Columns, 2, std::size_t>;
  std::vector<Eigen::Vector3d> points_;
  Tree tree_;
};

// The paper's neighbourhoods jump as points enter and leave, so that the steps may not shrink to
// nothing: what they settle within is taken.
std::optional<SurfaceSample> descend(const SurfaceEstimator& estimator, const Pose& X_WP,
                                     Eigen::Vector3d p) {
  constexpr double kConverged = 1e-7, kSettled = 5e-4;  // [m]
  double step = std::numeric_limits<double>::infinity();
  Eigen::Vector3d n;
  for (int i = 0; i < 12 && std::abs(step) > kConverged; ++i) {
    const SurfaceEstimate estimate = estimator.estimate(X_WP * p);
    n = X_WP.R.transpose() * estimate.n_W;
    if (estimate.status != SurfaceStatus::ok || n.z() < 0.05) return std::nullopt;
    step = estimate.distance / n.z();
    p.z() -= step;
  }
  if (std::abs(step) > kSettled) return std::nullopt;
  return SurfaceSample{p, n};
}

}  // namespace

SurfaceHeight canvas_height(const Canvas& canvas, const Pose& X_WP) {
  // From farther out than any of the canvas, wherever the frame's origin is.
  const double out = (canvas.bounds().center() - X_WP.p).dot(X_WP.R.col(2)) +
                     canvas.bounds().diagonal().norm() + 1.0;
  return [&canvas, X_WP, X_PW = X_WP.inverse(), out](double x,
                                                     double y) -> std::optional<SurfaceSample> {
    const auto hit = canvas.ray(X_WP * Eigen::Vector3d(x, y, out), -X_WP.R.col(2));
    if (!hit) return std::nullopt;
    return SurfaceSample{X_PW * hit->p_W, X_PW.R * hit->n_W};
  };
}

SurfaceHeight level_surface(double z) {
  return [z](double x, double y) { return SurfaceSample{{x, y, z}, Eigen::Vector3d::UnitZ()}; };
}

SurfaceHeight perceived_height(const SurfaceEstimator& estimator, const Pose& X_WP) {
  return [&estimator, X_WP, columns = std::make_shared<Columns>(estimator.cloud(), X_WP.inverse()),
          last = Eigen::Vector3d(Eigen::Vector3d::Constant(1e9))](
             double x, double y) mutable -> std::optional<SurfaceSample> {
    std::optional<SurfaceSample> sample;
    if (std::hypot(last.x() - x, last.y() - y) < 0.01)
      sample = descend(estimator, X_WP, {x, y, last.z()});
    if (!sample) sample = descend(estimator, X_WP, {x, y, columns->height_at(x, y)});
    if (sample) last = sample->p_P;
    return sample;
  };
}

}  // namespace impedraw

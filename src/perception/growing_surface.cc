#include "impedraw/perception/growing_surface.h"

#include <algorithm>
#include <utility>

namespace impedraw {

namespace {

using Eigen::Vector3d;

// Added to each point's deviation for its weight [m]: the model's own errors. It also keeps points
// that were seen once from counting for nothing beside those that were seen often.
constexpr double kLeastDeviation = 1e-4;
constexpr double kFarAway = 1e3;  // of the eyes [m]

SurfaceEstimate blended(const SurfaceEstimate& a, const SurfaceEstimate& b, double share) {
  if (a.status != SurfaceStatus::ok || share >= 1.0) return b;
  if (b.status != SurfaceStatus::ok || share <= 0.0) return a;
  return {SurfaceStatus::ok, ((1.0 - share) * a.n_W + share * b.n_W).normalized(),
          (1.0 - share) * a.distance + share * b.distance};
}

}  // namespace

PointCloud cloud_of(std::span<const SurfaceModel::Point> points) {
  PointCloud cloud;
  // Normals point to the eye of their point. The model knows their side already.
  for (const double x : {-1.0, 0.0, 1.0})
    for (const double y : {-1.0, 0.0, 1.0})
      for (const double z : {-1.0, 0.0, 1.0})
        if (x != 0.0 || y != 0.0 || z != 0.0)
          cloud.eyes.push_back(kFarAway * Vector3d(x, y, z).normalized());
  for (const SurfaceModel::Point& point : points) {
    cloud.points.push_back(point.p);
    cloud.weight.push_back(kLeastDeviation * kLeastDeviation /
                           (kLeastDeviation * kLeastDeviation + 1.0 / point.weight));
    const auto eye = std::max_element(
        cloud.eyes.begin(), cloud.eyes.end(),
        [&](const Vector3d& a, const Vector3d& b) { return a.dot(point.n) < b.dot(point.n); });
    cloud.camera.push_back(static_cast<int>(eye - cloud.eyes.begin()));
  }
  return cloud;
}

GrowingSurface::GrowingSurface(const SurfaceEstimator& snapshot, const NormalSettings& settings,
                               bool lock_step)
    : snapshot_(snapshot), settings_(settings), lock_step_(lock_step) {
  offered_.reserve(snapshot.cloud().points.size());
  second_ = std::thread([this] { build_what_is_offered(); });
}

GrowingSurface::~GrowingSurface() {
  ends_ = true;
  ++posted_;
  posted_.notify_one();
  second_.join();
}

void GrowingSurface::offer(std::span<const SurfaceModel::Point> points, double time) {
  if (posted_ != built_ || time < begun_ + kPeriod ||
      points.size() <= static_cast<std::size_t>(settings_.k))
    return;
  double known = 0.0;
  for (const SurfaceModel::Point& point : points) known += point.weight;
  const bool first = points_ == 0;
  if (!first && known < kKnownMore * known_ &&
      static_cast<double>(points.size()) < kGrown * static_cast<double>(points_))
    return;
  offered_.assign(points.begin(), points.end());
  known_ = known;
  points_ = points.size();
  begun_ = time;
  ++posted_;
  posted_.notify_one();
}

void GrowingSurface::build_what_is_offered() noexcept {
  std::shared_ptr<const SurfaceEstimator> before;
  for (unsigned done = 0;; ++done) {
    posted_.wait(done);
    if (ends_) return;
    auto now = std::make_shared<const SurfaceEstimator>(cloud_of(offered_), settings_);
    latest_.slot() = {now, std::exchange(before, now)};
    latest_.give();
    ++built_;
    built_.notify_one();
  }
}

void GrowingSurface::update(double time) noexcept {
  now_ = time;
  if (lock_step_) {
    const auto taken = static_cast<unsigned>(count_);
    if (posted_ == taken || time < begun_ + kBuilding) return;
    built_.wait(taken);
  }
  if (!latest_.refresh()) return;
  taken_ = time;
  ++count_;
}

SurfaceEstimate GrowingSurface::estimate(const Vector3d& p_K) const noexcept {
  const Surfaces& surfaces = latest_.value();
  if (!surfaces.now) return snapshot_.estimate(p_K);
  const double rough = snapshot_.finer_share(p_K);
  if (rough >= 1.0) return snapshot_.estimate(p_K);
  SurfaceEstimate estimate = surfaces.now->estimate(p_K);
  const double u = std::clamp((now_ - taken_) / kGoingOver, 0.0, 1.0);
  if (u < 1.0) {
    const SurfaceEstimator& before = surfaces.before ? *surfaces.before : snapshot_;
    estimate = blended(before.estimate(p_K), estimate, u * u * (3.0 - 2.0 * u));
  }
  if (rough > 0.0 || estimate.status != SurfaceStatus::ok)
    estimate = blended(snapshot_.estimate(p_K), estimate,
                       estimate.status == SurfaceStatus::ok ? 1.0 - rough : 0.0);
  return estimate;
}

}  // namespace impedraw

#include "impedraw/perception/normals.h"

#include <cmath>
#include <limits>
#include <utility>

#include "impedraw/common/in_parallel.h"
#include "impedraw/perception/detail_levels.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr int kInterpolated = 10;  // precomputed normals per query
// the one-sidedness of so few points scatters: 0.4 within the cloud, 0.6 ± 0.1 on its edge
constexpr double kInterpolatedEdge = 0.8;

}  // namespace

SurfaceEstimator::SurfaceEstimator(PointCloud cloud, const NormalSettings& settings,
                                   FinerClouds finer)
    : patches_(std::make_unique<CloudPatches>(std::move(cloud), settings)) {
  fit_every_point();
  if (settings.mode == NormalMode::fresh)
    levels_ = DetailLevels::of(*patches_, known_, reach2_, std::move(finer));
  const bool interpolates = settings.mode == NormalMode::interpolated;
  if (!uses_finer() && !interpolates) return;
  in_halves(patches_->size(), [&](int begin, int end) {
    for (int i = begin; i < end; ++i)
      if (interpolates)
        at_points_[i] = estimate(patches_->cloud().points[i]);
      else if (at_points_[i].status == SurfaceStatus::ok)
        at_points_[i] = levels_->refined(patches_->cloud().points[i], i, at_points_[i],
                                         settings.max_one_sidedness);
  });
}
SurfaceEstimator::~SurfaceEstimator() = default;
SurfaceEstimator::SurfaceEstimator(SurfaceEstimator&&) noexcept = default;
SurfaceEstimator& SurfaceEstimator::operator=(SurfaceEstimator&&) noexcept = default;

void SurfaceEstimator::fit_every_point() {
  const NormalSettings& s = patches_->settings();
  const int n = patches_->size();
  std::vector<Vector3d> normals(n, Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  reach2_.resize(n);
  known_.resize(n);
  at_points_.resize(n);
  in_halves(n, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Vector3d& p = patches_->cloud().points[i];
      Patch patch = patches_->nearest(p, s.k, i > begin ? reach2_[i - 1] : 0.0);
      patch.closest = i;
      reach2_[i] = patch.reach2(s);
      known_[i] = patches_->fit(p, patch);
      at_points_[i].status = status_of(known_[i], s.max_one_sidedness);
      if (at_points_[i].status != SurfaceStatus::ok) continue;
      at_points_[i] = {SurfaceStatus::ok, known_[i].n, known_[i].distance};
      normals[i] = known_[i].n;
    }
  });
  patches_->set_normals(std::move(normals));
}

SurfaceEstimate SurfaceEstimator::estimate(const Vector3d& p,
                                           RecentSurface* recent) const noexcept {
  if (!p.allFinite()) return {.status = SurfaceStatus::too_few};
  const NormalSettings& s = patches_->settings();
  if (s.mode == NormalMode::interpolated) return interpolated(p, s.max_one_sidedness);
  const Patch patch =
      recent ? patches_->nearest(p, s.k, &recent->widest) : patches_->gathered(p, s.k, reach2_);
  const LocalSurface surface = patches_->fit(p, patch);
  const SurfaceStatus status = status_of(surface, s.max_one_sidedness);
  if (status != SurfaceStatus::ok) return {.status = status};
  const SurfaceEstimate coarse{status, surface.n, surface.distance};
  return levels_ ? levels_->refined(p, patch.closest, coarse, s.max_one_sidedness, recent) : coarse;
}

// Each neighbour i has a surface point f_i, its normal n_i and the derivative bend_i. It predicts
// the normal n_i + bend_i (p − f_i) at p. n is the average of these predictions. Between f_i and
// the query's foot the normal changes from n_i to n. The rise of a parabola follows the mean of
// both slopes, so the distance is (n_i + n)/|n_i + n| · (p − f_i), exact to second order.
SurfaceEstimate SurfaceEstimator::interpolated(const Vector3d& p,
                                               double max_one_sidedness) const noexcept {
  const Patch near = patches_->nearest(p, kInterpolated + 1);
  if (near.n <= kInterpolated || !(near.squared[kInterpolated] > 0.0))
    return {.status = SurfaceStatus::too_few};
  double weight[kInterpolated];
  Vector3d foot[kInterpolated];  // of each point on its surface: without its noise
  double sum = 0.0;
  double lost = 0.0;
  Vector3d n = Vector3d::Zero();
  Vector3d mean = Vector3d::Zero();
  for (int i = 0; i < kInterpolated; ++i) {
    const LocalSurface& at = known_[near.index[i]];
    const double fade = 1.0 - near.squared[i] / near.squared[kInterpolated];
    const bool ok = status_of(at, max_one_sidedness) == SurfaceStatus::ok;
    weight[i] = ok ? fade * fade : 0.0;
    lost += fade * fade - weight[i];
    if (weight[i] == 0.0) continue;
    sum += weight[i];
    foot[i] = patches_->cloud().points[near.index[i]] - at.distance * at.n;
    n += weight[i] * (at.n + at.bend * (p - foot[i]));
    mean += weight[i] * (foot[i] - p);
  }
  if (!(sum > lost) || !(n.norm() > 0.5 * sum)) {
    const SurfaceStatus nearest = status_of(known_[near.index[0]], max_one_sidedness);
    return {.status = nearest == SurfaceStatus::ok ? SurfaceStatus::too_few : nearest};
  }
  n.normalize();
  mean /= sum;
  double distance = 0.0;
  double spread = 0.0;
  for (int i = 0; i < kInterpolated; ++i) {
    if (weight[i] == 0.0) continue;
    const Vector3d from = p - foot[i];
    distance += weight[i] * (known_[near.index[i]].n + n).normalized().dot(from);
    spread += weight[i] * (from - n * n.dot(from)).squaredNorm();
  }
  const double offset = (mean - n * n.dot(mean)).norm();
  if (offset > kInterpolatedEdge * std::sqrt(spread / sum))
    return {.status = SurfaceStatus::off_edge};
  return {SurfaceStatus::ok, n, distance / sum};
}

bool SurfaceEstimator::uses_finer() const noexcept { return levels_ && levels_->any(); }

double SurfaceEstimator::finer_share(const Vector3d& p) const noexcept {
  return levels_ && p.allFinite() ? levels_->finer_share(p) : 0.0;
}

Roughness SurfaceEstimator::roughness(const Vector3d& p) const noexcept {
  if (!levels_ || !p.allFinite()) return {};
  const int nearest = patches_->nearest(p, 1).closest;
  return nearest < 0 ? Roughness{} : levels_->roughness(nearest);
}

const PointCloud& SurfaceEstimator::cloud() const noexcept { return patches_->cloud(); }

}  // namespace impedraw

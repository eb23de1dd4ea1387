#include "impedraw/perception/normals.h"

#include <limits>
#include <utility>

#include "impedraw/common/in_parallel.h"
#include "impedraw/perception/detail_levels.h"

namespace impedraw {

using Eigen::Vector3d;

SurfaceEstimator::SurfaceEstimator(PointCloud cloud, const NormalSettings& settings,
                                   FinerClouds finer)
    : patches_(std::make_unique<CloudPatches>(std::move(cloud), settings)) {
  fit_every_point();
  levels_ = DetailLevels::of(*patches_, known_, reach2_, std::move(finer));
  if (!uses_finer()) return;
  in_halves(patches_->size(), [&](int begin, int end) {
    for (int i = begin; i < end; ++i)
      if (at_points_[i].status == SurfaceStatus::ok)
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
  const Patch patch =
      recent ? patches_->nearest(p, s.k, &recent->widest) : patches_->gathered(p, s.k, reach2_);
  const LocalSurface surface = patches_->fit(p, patch);
  const SurfaceStatus status = status_of(surface, s.max_one_sidedness);
  if (status != SurfaceStatus::ok) return {.status = status};
  const SurfaceEstimate coarse{status, surface.n, surface.distance};
  return levels_ ? levels_->refined(p, patch.closest, coarse, s.max_one_sidedness, recent) : coarse;
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

#include "impedraw/perception/cloud_patches.h"

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

void validate(const PointCloud& cloud, const NormalSettings& s) {
  RangeChecks("normals")
      .field("k", s.k, NormalSettings::kNeighbours, "")
      .field("max_radius", s.max_radius, {0.001, 1.0}, "m")
      .field("max_one_sidedness", s.max_one_sidedness, Range::positive_to(1.0), "");
  if (cloud.points.empty()) {
    throw InputError(
        "normals: the cloud has no points: check that the cameras see the canvas and that the "
        "region contains it");
  }
  if (cloud.camera.size() != cloud.points.size()) {
    throw InputError(fmt::format("normals: the cloud has {} points and {} camera indices",
                                 cloud.points.size(), cloud.camera.size()));
  }
  if (!cloud.weight.empty() && cloud.weight.size() != cloud.points.size()) {
    throw InputError(fmt::format("normals: the cloud has {} points and {} weights",
                                 cloud.points.size(), cloud.weight.size()));
  }
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!cloud.points[i].allFinite())
      throw InputError(fmt::format("normals: point {} of the cloud is not finite", i));
    if (!cloud.weight.empty() && !(cloud.weight[i] > 0.0)) {
      throw InputError(
          fmt::format("normals: point {} of the cloud has weight {}, must be greater than 0", i,
                      cloud.weight[i]));
    }
    if (cloud.camera[i] < 0 || cloud.camera[i] >= static_cast<int>(cloud.eyes.size())) {
      throw InputError(fmt::format("normals: point {} of the cloud names camera {}, it has {}", i,
                                   cloud.camera[i], cloud.eyes.size()));
    }
  }
}

PointCloud in_tree_order(const PointCloud& cloud, const NormalSettings& s) {
  validate(cloud, s);
  PointCloud ordered;
  ordered.eyes = cloud.eyes;
  for (const int i : tree_order(cloud.points)) append(cloud, static_cast<std::size_t>(i), &ordered);
  if (cloud.weight.empty()) ordered.weight.assign(ordered.points.size(), 1.0);
  return ordered;
}

}  // namespace

CloudPatches::CloudPatches(PointCloud cloud, const NormalSettings& settings)
    : settings_(settings), cloud_(in_tree_order(cloud, settings)), tree_(cloud_.points) {}

Patch CloudPatches::nearest(const Vector3d& p, int k, double guess2) const noexcept {
  Patch patch;
  patch.k = k;
  patch.n = tree_.nearest(p, k, settings_.max_radius, patch.index, patch.squared, guess2);
  if (patch.n > 0) patch.closest = patch.index[0];
  return patch;
}

Patch CloudPatches::gathered(const Vector3d& p, int k,
                             const std::vector<double>& reach2) const noexcept {
  Patch patch;
  patch.k = k;
  patch.n = tree_.nearest_unordered(p, k, settings_.max_radius, reach2, patch.index, patch.squared,
                                    &patch.closest);
  return patch;
}

Patch CloudPatches::nearest(const Vector3d& p, int k, RecentNeighbours* recent) const noexcept {
  Patch patch;
  patch.k = k;
  patch.n =
      recent->nearest(tree_, cloud_.points, p, k, settings_.max_radius, patch.index, patch.squared);
  if (patch.n > 0) patch.closest = patch.index[0];
  return patch;
}

bool CloudPatches::about(const Vector3d& p, const Patch& patch,
                         Neighbourhood* around) const noexcept {
  if (patch.n < patch.k || !(patch.squared[patch.k - 1] > 0.0)) return false;
  around->n = patch.k;
  const double furthest2 = patch.squared[patch.k - 1];
  for (int i = 0; i < patch.k; ++i) {
    const Vector3d& q = cloud_.points[patch.index[i]];
    around->x[i] = q.x() - p.x();
    around->y[i] = q.y() - p.y();
    around->z[i] = q.z() - p.z();
    const double fade = 1.0 - patch.squared[i] / furthest2;
    around->w[i] = settings_.weighting == NeighbourWeighting::smooth
                       ? cloud_.weight[patch.index[i]] * fade * fade
                       : 1.0;
  }
  return true;
}

Vector3d CloudPatches::towards_eye(const Patch& patch) const noexcept {
  return cloud_.eyes[cloud_.camera[patch.closest]] - cloud_.points[patch.closest];
}

LocalSurface CloudPatches::fit(const Vector3d& p, const Patch& patch) const noexcept {
  Neighbourhood around;
  if (!about(p, patch, &around)) return {};
  return fit_surface(around, settings_.fit, towards_eye(patch));
}

}  // namespace impedraw

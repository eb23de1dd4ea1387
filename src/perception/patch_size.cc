#include "impedraw/perception/patch_size.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "impedraw/perception/cloud_patches.h"

namespace impedraw {

int calm_patch(const PointCloud& cloud, const NormalSettings& settings) {
  constexpr int kAsked = 1000;  // patches
  const CloudPatches patches(cloud, settings);
  std::vector<double> errors;
  for (int i = 0; i < patches.size(); i += patches.size() / kAsked + 1) {
    const Eigen::Vector3d& p = patches.cloud().points[static_cast<std::size_t>(i)];
    const Patch patch = patches.nearest(p, settings.k);
    if (patch.n < settings.k) continue;
    const LocalSurface surface = patches.fit(p, patch);
    if (status_of(surface, settings.max_one_sidedness) != SurfaceStatus::ok) continue;
    errors.push_back(4.0 * surface.residual / std::sqrt(settings.k * patch.squared[patch.n - 1]));
  }
  if (errors.empty()) return settings.k;
  const auto smooth = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 4);
  std::nth_element(errors.begin(), smooth, errors.end());
  const double k = std::ceil(settings.k * *smooth / kCalmNormal);
  return std::max(settings.k, static_cast<int>(std::min<double>(k, kMostNeighbours)));
}

}  // namespace impedraw

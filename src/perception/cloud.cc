#include "impedraw/perception/cloud.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kMostCubes = 2097152.0;  // along one axis: 21 bits

void validate(const std::vector<DepthImage>& images, const std::vector<DepthCamera>& cameras,
              const CloudSettings& settings, const std::vector<Capsule>& arm) {
  if (images.size() != cameras.size()) {
    throw InputError(
        fmt::format("cloud: {} depth images for {} cameras", images.size(), cameras.size()));
  }
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    validate(cameras[c]);
    const DepthImage& image = images[c];
    const bool full =
        image.depth.size() == static_cast<std::size_t>(cameras[c].width) * cameras[c].height;
    if (image.width != cameras[c].width || image.height != cameras[c].height || !full) {
      throw InputError(fmt::format("cloud: image {} has {} × {} px ({} depths), its camera {} × {}",
                                   c, image.width, image.height, image.depth.size(),
                                   cameras[c].width, cameras[c].height));
    }
  }
  if (settings.region.isEmpty())
    throw InputError("cloud: region is empty, its min must be below its max along x, y and z");
  require_in_range("cloud", CloudSettings::Limits::self_padding, settings.self_padding);
  for (std::size_t i = 0; i < arm.size(); ++i) {
    if (!arm[i].a_W.allFinite() || !arm[i].b_W.allFinite() || !(arm[i].radius >= 0.0)) {
      throw InputError(fmt::format(
          "cloud: capsule {} of the arm must have finite ends and a radius of at least 0", i));
    }
  }
}

}  // namespace

void append(const PointCloud& from, std::size_t i, PointCloud* to) {
  to->points.push_back(from.points[i]);
  to->camera.push_back(from.camera[i]);
  if (!from.weight.empty()) to->weight.push_back(from.weight[i]);
  if (!from.rgb.empty()) to->rgb.insert(to->rgb.end(), &from.rgb[3 * i], &from.rgb[3 * i] + 3);
}

bool inside(const Capsule& capsule, double padding, const Vector3d& p) noexcept {
  const Vector3d axis = capsule.b_W - capsule.a_W;
  const double length2 = axis.squaredNorm();
  const double s = length2 > 0.0 ? std::clamp(axis.dot(p - capsule.a_W) / length2, 0.0, 1.0) : 0.0;
  const double reach = capsule.radius + padding;
  return (capsule.a_W + s * axis - p).squaredNorm() <= reach * reach;
}

PointCloud back_project(const std::vector<DepthImage>& images,
                        const std::vector<DepthCamera>& cameras, const CloudSettings& settings,
                        const std::vector<Capsule>& arm) {
  validate(images, cameras, settings, arm);
  PointCloud cloud;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    const DepthCamera& camera = cameras[c];
    cloud.eyes.push_back(camera.X_WC.p);
    for (int j = 0; j < camera.height; ++j) {
      for (int i = 0; i < camera.width; ++i) {
        const double depth = images[c].at(i, j);
        if (!(depth > 0.0) || !std::isfinite(depth)) continue;
        const Vector3d p = camera.X_WC * (depth * camera.direction_C(i, j));
        if (!settings.region.contains(p)) continue;
        const auto hides = [&](const Capsule& capsule) {
          return inside(capsule, settings.self_padding, p);
        };
        if (std::any_of(arm.begin(), arm.end(), hides)) continue;
        cloud.points.push_back(p);
        cloud.camera.push_back(static_cast<int>(c));
      }
    }
  }
  return cloud;
}

PointCloud thin(const PointCloud& cloud, double voxel) {
  require_in_range("cloud", CloudSettings::Limits::voxel, voxel);
  if (voxel == 0.0 || cloud.points.empty()) return cloud;
  const auto cube = [&](const Vector3d& p) { return Vector3d((p / voxel).array().floor()); };
  Vector3d lowest = cube(cloud.points.front()), highest = lowest;
  for (const auto& p : cloud.points) {
    lowest = lowest.cwiseMin(cube(p));
    highest = highest.cwiseMax(cube(p));
  }
  if (!((highest - lowest).maxCoeff() < kMostCubes)) {
    throw InputError(
        fmt::format("cloud: voxel = {} m is too small for points {} m apart: take a larger one, or "
                    "a smaller region",
                    voxel, ((highest - lowest) * voxel).maxCoeff()));
  }
  struct Entry {
    std::uint64_t cube;
    std::size_t point;
  };
  std::vector<Entry> entries(cloud.points.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const Eigen::Matrix<std::uint64_t, 3, 1> k =
        (cube(cloud.points[i]) - lowest).cast<std::uint64_t>();
    entries[i] = {(k.x() << 42) | (k.y() << 21) | k.z(), i};
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.cube != b.cube ? a.cube < b.cube : a.point < b.point;
  });

  PointCloud thinned;
  thinned.eyes = cloud.eyes;
  const bool coloured = !cloud.rgb.empty();
  std::vector<int> seen(cloud.eyes.size());
  for (std::size_t i = 0; i < entries.size();) {
    const std::size_t begin = i;
    Vector3d sum = Vector3d::Zero(), colour = Vector3d::Zero();
    double weight = 0.0;
    std::fill(seen.begin(), seen.end(), 0);
    for (; i < entries.size() && entries[i].cube == entries[begin].cube; ++i) {
      const double w = cloud.weight.empty() ? 1.0 : cloud.weight[entries[i].point];
      sum += w * cloud.points[entries[i].point];
      weight += w;
      if (coloured)
        for (int c = 0; c < 3; ++c) colour[c] += w * cloud.rgb[3 * entries[i].point + c];
      ++seen[cloud.camera[entries[i].point]];
    }
    thinned.points.push_back(sum / weight);
    thinned.weight.push_back(weight);
    if (coloured)
      for (const double c : colour)
        thinned.rgb.push_back(static_cast<std::uint8_t>(std::lround(c / weight)));
    thinned.camera.push_back(
        static_cast<int>(std::max_element(seen.begin(), seen.end()) - seen.begin()));
  }
  return thinned;
}

PointCloud fuse(const std::vector<DepthImage>& images, const std::vector<DepthCamera>& cameras,
                const CloudSettings& settings, const std::vector<Capsule>& arm) {
  return thin(back_project(images, cameras, settings, arm), settings.voxel);
}

}  // namespace impedraw

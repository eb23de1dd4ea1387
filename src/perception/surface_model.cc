#include "impedraw/perception/surface_model.h"

#include <bit>

#include "impedraw/common/errors.h"

namespace impedraw {

namespace {

constexpr double kSameSide = 0.7;  // cosine
constexpr double kBeside = 0.5;    // as near along the surface belongs to a point [cubes]

// Cubes on top of each other stand side by side in the table: they are looked up together.
std::size_t hash(const Eigen::Matrix<std::int32_t, 3, 1>& c) {
  return static_cast<std::size_t>(((static_cast<std::uint64_t>(c.x()) * 73856093u) ^
                                   (static_cast<std::uint64_t>(c.y()) * 19349663u)) +
                                  static_cast<std::uint64_t>(c.z()));
}

}  // namespace

SurfaceModel::SurfaceModel(double voxel, std::size_t most) : voxel_(voxel), most_(most) {
  if (!(voxel >= 1e-4 && voxel <= 0.1))
    throw InputError("surface model: voxel must be from 0.0001 to 0.1 m");
  if (most < 1 || most > 100000000)
    throw InputError("surface model: it must have room for 1 to 1e8 points");
  points_.reserve(most);
  cubes_.reserve(most);
  slots_.assign(std::bit_ceil(2 * most), 0);
}

SurfaceModel::Cube SurfaceModel::cube_of(const Eigen::Vector3d& p_K) const noexcept {
  return (p_K / voxel_).array().floor().cast<std::int32_t>();
}

// Slot of the cube with that hash, or the empty one where it belongs.
std::size_t SurfaceModel::slot_of(const Cube& cube, std::size_t hash) const noexcept {
  const std::size_t mask = slots_.size() - 1;
  std::size_t at = hash & mask;
  while (slots_[at] != 0 && cubes_[slots_[at] - 1] != cube) at = (at + 1) & mask;
  return at;
}

// Calls f with the index of each point of the 27 cubes about p_K that faces as n_K does.
template <typename F>
void SurfaceModel::each_about(const Eigen::Vector3d& p_K, const Eigen::Vector3d& n_K,
                              F&& f) const noexcept {
  const Cube lowest = cube_of(p_K) - Cube::Ones();
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y) {
      const std::size_t column = hash(lowest + Cube(x, y, 0));
      for (int z = 0; z < 3; ++z) {
        if (slots_[(column + z) & (slots_.size() - 1)] == 0) continue;
        const std::uint32_t found = slots_[slot_of(lowest + Cube(x, y, z), column + z)];
        if (found != 0 && points_[found - 1].n.dot(n_K) >= kSameSide) f(found - 1);
      }
    }
}

void SurfaceModel::add(std::span<const SeenPoint> samples, const Pose& X_WK) noexcept {
  const Pose X_KW = X_WK.inverse();
  for (const SeenPoint& s : samples) {
    if (!(s.deviation > 0.0) || !s.p.allFinite()) continue;
    const Eigen::Vector3d p = X_KW * s.p, n = X_KW.R * s.n;
    if (!(p.cwiseAbs().maxCoeff() < 1e4)) continue;
    std::size_t at = beside(p, n);
    if (at == points_.size()) {
      const Cube cube = cube_of(p);
      const std::size_t slot = slot_of(cube, hash(cube));
      if (slots_[slot] == 0) {
        if (points_.size() == most_) continue;
        points_.push_back({});
        cubes_.push_back(cube);
        slots_[slot] = static_cast<std::uint32_t>(points_.size());
      }
      at = slots_[slot] - 1;
    }
    Point& point = points_[at];
    if (point.samples > 0 && point.n.dot(n) < 0.0) continue;
    const double w = 1.0 / (s.deviation * s.deviation), all = point.weight + w;
    point.p += (w / all) * (p - point.p);
    point.n = (point.weight * point.n + w * n).normalized();
    point.weight = all;
    ++point.samples;
  }
}

// The point that the sample belongs to: the nearest one along the surface. Its distance along the
// normal may be noise, and must not put it into another cube.
std::size_t SurfaceModel::beside(const Eigen::Vector3d& p_K,
                                 const Eigen::Vector3d& n_K) const noexcept {
  std::size_t best = points_.size();
  double least = kBeside * kBeside * voxel_ * voxel_;
  each_about(p_K, n_K, [&](std::size_t at) {
    const Eigen::Vector3d way = p_K - points_[at].p;
    const double along = points_[at].n.dot(way), distance = way.squaredNorm() - along * along;
    if (distance >= least) return;
    best = at;
    least = distance;
  });
  return best;
}

const SurfaceModel::Point* SurfaceModel::nearest(const Eigen::Vector3d& p_K,
                                                 const Eigen::Vector3d& n_K) const noexcept {
  if (!(p_K.cwiseAbs().maxCoeff() < 1e4)) return nullptr;
  const Point* best = nullptr;
  double least = 0.0;
  each_about(p_K, n_K, [&](std::size_t at) {
    const double distance = (points_[at].p - p_K).squaredNorm();
    if (best && distance >= least) return;
    best = &points_[at];
    least = distance;
  });
  return best;
}

}  // namespace impedraw

// Finer clouds of the same view, for where the surface is rougher than the cloud's patches resolve.
//
// At each point of the cloud the k-patch is fitted at every level, the finer ones with smaller
// patches. Their normals err by noise, s/(√k R) for points with noise s on a patch of radius R, and
// by misfit: shape that a quadric over the patch cannot follow, b/R with b² = residual² − s². The
// noise s is taken from the finest level, where misfit is least. The level with the least error is
// used; a finer one only where it is clearly better. Between places with different levels the
// estimates are blended.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "impedraw/perception/cloud_patches.h"
#include "impedraw/perception/cube_set.h"

namespace impedraw {

class DetailLevels {
 public:
  // Null where no finer cloud has more than k points. `widest` must outlive the levels. `fits` and
  // `reach2`: its surfaces and Patch::reach2() at each of its points.
  static std::unique_ptr<const DetailLevels> of(const CloudPatches& widest,
                                                const std::vector<LocalSurface>& fits,
                                                const std::vector<double>& reach2,
                                                FinerClouds finer);

  // Blends the two levels' estimates next to that of p. `coarse`, the widest patches' estimate,
  // where those serve. `closest`: the point of the widest cloud nearest to p, or −1.
  SurfaceEstimate refined(const Eigen::Vector3d& p, int closest, const SurfaceEstimate& coarse,
                          double max_one_sidedness, RecentSurface* recent = nullptr) const noexcept;
  // Share of a finer level at p, 0 to 1.
  double finer_share(const Eigen::Vector3d& p) const noexcept;

  // Some place needs a finer cloud.
  bool any() const noexcept { return !finer_.empty(); }
  // A finer level is in use near a point of the widest cloud.
  bool used_near(int point) const noexcept { return any() && level_nearby_[point] > 0.0f; }
  const Roughness& roughness(int point) const noexcept { return rough_[point]; }
  // The surface steps within kStepMargin of a point of the widest cloud.
  bool steps_near(int point) const noexcept { return steps_[point]; }
  const NeighbourTree& finest() const noexcept { return finest_->tree(); }
  // The finest cloud has a point in the cube of side kCube about p: one nearer than √3 kCube.
  static constexpr double kCube = 1.15e-3;  // [m]
  bool finest_in_cube(const Eigen::Vector3d& p) const noexcept {
    return finest_cubes_.contains(cube_of(p, kCube));
  }
  double noise() const noexcept { return noise_; }  // median residual of the finest patches [m]

 private:
  struct Level {
    std::shared_ptr<const CloudPatches> patches;
    int k;
    std::vector<double> reach2;
  };
  // One fit at p, and what it tells about the surface there.
  struct Trial {
    bool ok = false;
    double residual = 0.0, radius = 0.0, weight = 1.0;
    int k = 1;
  };
  // Residuals of the widest and the finest patch at a point, and the finest one's radius [m].
  struct Residuals {
    double widest = 0.0, finest = 0.0, radius = 0.0;
  };

  explicit DetailLevels(const CloudPatches& widest) : widest_(widest) {}
  static Trial trial_of(const LocalSurface& fit, int k, double radius2, const NormalSettings& s);
  static Trial try_fit(const CloudPatches& patches, int k, const Eigen::Vector3d& p, double guess2);
  void choose_levels(const std::vector<LocalSurface>& fits, const std::vector<double>& reach2);
  float choose_level(int i, const Trial& widest, Residuals* residuals);
  void spread(const std::vector<float>& best);
  void find_steps(const std::vector<Residuals>& residuals);
  double level_at(const Eigen::Vector3d& p, RecentSurface* recent = nullptr) const noexcept;
  SurfaceEstimate at_level(int l, const Eigen::Vector3d& p, double max_one_sidedness,
                           RecentSurface* recent) const noexcept;

  const CloudPatches& widest_;
  std::vector<Level> finer_;  // empty where no place needs one
  std::shared_ptr<const CloudPatches> finest_;
  CubeSet finest_cubes_;
  // For each point of the widest cloud: the level to use, 0 for that cloud itself, and the greatest
  // nearby.
  std::vector<float> level_, level_nearby_;
  std::vector<Roughness> rough_;
  std::vector<char> steps_;
  double noise_ = 0.0;
};

}  // namespace impedraw

// Estimates the normal and distance of the surface under the pen tip from the point cloud:
// equations (18) and (19).
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "impedraw/common/range.h"
#include "impedraw/control/surface_estimate.h"
#include "impedraw/perception/cloud.h"
#include "impedraw/perception/local_surface.h"

namespace impedraw {

class CloudPatches;
class DetailLevels;
struct RecentSurface;

enum class NeighbourWeighting {
  // as in the paper: 1/k each. A point that enters or leaves the set makes the normal jump
  uniform,
  // PointCloud::weight (1 − d²/d_k²)², d_k the distance of the furthest neighbour: a point enters
  // and leaves the set with weight 0
  smooth,
};

// Along the sine on the standard bowl, three standard cameras, mean | max error of the normal
// [deg], error of the distance [mm]:
//   perfect cameras, voxel 4 mm:    k = 40: 0.002 | 0.007, 0.005    k = 60: 0.001 | 0.004, 0.005
//       the paper's plane, 1/k each                                 k = 60: 0.083 | 0.25, 0.22
//   realistic noise, voxel 4 mm:    k = 60: 0.75 | 2.0, 0.10        k = 120: 0.35 | 1.0, 0.07
//   realistic noise, voxel 6 mm:    k = 60: 0.30 | 0.8, 0.06        k = 90: 0.18 | 0.5, 0.04
//   k = 120: 0.12 | 0.36, 0.04
//   realistic noise, voxel 8 mm:    k = 60: 0.17 | 0.6, 0.05        k = 90: 0.10 | 0.3, 0.04
// Wider patches average out more noise but lose fine shape. Only on a sphere does this cost
// nothing.
struct NormalSettings {
  // neighbours N(p) of the query (18); a quadric has six coefficients
  int k = 60;
  // search radius around the query [m]; fewer than k neighbours within it: too_few
  double max_radius = 0.06;
  NeighbourWeighting weighting = NeighbourWeighting::smooth;
  SurfaceFit fit = SurfaceFit::quadric;
  // Above this value (LocalSurface::one_sidedness) the query is off the cloud's edge. On a straight
  // edge the value is 0.59; 0.66 permits about a tenth of the patch's radius beyond the edge.
  double max_one_sidedness = 0.66;

  static constexpr Range kNeighbours{8, kMostNeighbours};  // allowed as k
};

// From coarse to fine, to be used where they are better: see detail_levels.h.
using FinerClouds = std::vector<PointCloud>;

// Roughness of the surface at a point, as the cloud shows it.
struct Roughness {
  double residual = 0.0;  // RMS distance of points from the fit that is used there [m]
  double radius = 0.0;    // of that fit's patch [m]
  double misfit = 0.0;    // part of the residual that noise does not explain [m]
  double slope = 0.0;     // error of the normal to be expected from both [rad]

  // A patch has a larger misfit over a step of the surface alone [m].
  static constexpr double kStepMisfit = 8e-4;
  // By the misfit of a patch that is small enough: in a wider one it is shape that a smaller patch
  // would follow. Such a patch says nothing.
  static constexpr double kTelling = 8e-3;  // its radius at most [m]
  bool rougher_than(double most_misfit) const noexcept {
    return radius <= kTelling && misfit > most_misfit;
  }
};

// The surface that a cloud shows. estimate() finds neighbours, covariance and eigenvector anew for
// each query, as the paper does. It is const, may run in any number of threads, and allocates
// nothing.
//
// Normals point to the camera that saw the nearest neighbour. The distance is measured to the
// fitted surface, not to the nearest point, which can be half a point spacing away along the
// surface. Status:
//   too_few   fewer than k points within max_radius, or points that do not define a plane
//   off_edge  the points lie to one side of the query
// n_W and distance are valid only with status ok.
class SurfaceEstimator {
 public:
  // Fits a normal at every point of the cloud (into cloud().normals). Throws InputError naming a
  // bad setting, an empty cloud or a point that is not finite. `finer` may be empty.
  explicit SurfaceEstimator(PointCloud cloud, const NormalSettings& settings = {},
                            FinerClouds finer = {});
  ~SurfaceEstimator();
  SurfaceEstimator(SurfaceEstimator&&) noexcept;
  SurfaceEstimator& operator=(SurfaceEstimator&&) noexcept;

  // recent: what the caller keeps of this estimator's last queries; where those were near, as
  // under a moving tip, the query is cheaper. Null: nothing.
  SurfaceEstimate estimate(const Eigen::Vector3d& p_W,
                           RecentSurface* recent = nullptr) const noexcept;

  // estimate() at each point of the cloud: its coarse part is known already.
  const std::vector<SurfaceEstimate>& at_points() const noexcept { return at_points_; }

  // True if a finer cloud is used anywhere.
  bool uses_finer() const noexcept;
  // Degree to which the surface near p_W is too rough for the cloud itself: 0, where it serves, to
  // 1, where a finer cloud does.
  double finer_share(const Eigen::Vector3d& p_W) const noexcept;

  // At the point of the cloud nearest to p_W.
  Roughness roughness(const Eigen::Vector3d& p_W) const noexcept;

  // In the tree's order, so that neighbours are adjacent in memory.
  const PointCloud& cloud() const noexcept;

 private:
  friend class PlanSurface;  // the same patches and levels with another edge test
  void fit_every_point();

  std::unique_ptr<CloudPatches> patches_;
  std::vector<double> reach2_;                  // Patch::reach2() at each point of the cloud
  std::vector<LocalSurface> known_;             // fitted at each point of the cloud
  std::vector<SurfaceEstimate> at_points_;      // estimate() there
  std::unique_ptr<const DetailLevels> levels_;  // null: there are no finer clouds
};

}  // namespace impedraw

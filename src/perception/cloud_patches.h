// A cloud and the surfaces through its patches: the k points nearest to a query, equation (18), and
// the surface fitted to them, (19). Queries allocate nothing and may run in any number of threads.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/control/surface_estimate.h"
#include "impedraw/perception/cloud.h"
#include "impedraw/perception/local_surface.h"
#include "impedraw/perception/neighbours.h"
#include "impedraw/perception/normals.h"
#include "impedraw/perception/recent_neighbours.h"

namespace impedraw {

// N(p), for k points that were asked for.
struct Patch {
  int k = 0;
  int n = 0;                        // found; fewer than k: the others are too far
  int closest = -1;                 // −1: there is none
  int index[kMostNeighbours];       // the k-th point is the furthest
  double squared[kMostNeighbours];  // distances from the query [m²]

  // Squared radius within which the k points lie [m²].
  double reach2(const NormalSettings& s) const noexcept {
    return n == k ? squared[k - 1] : s.max_radius * s.max_radius;
  }
};

class CloudPatches {
 public:
  // Brings the points into the tree's order. Throws InputError naming a bad setting, an empty
  // cloud, or a point that is not finite.
  CloudPatches(PointCloud cloud, const NormalSettings& settings);
  CloudPatches(const CloudPatches&) = delete;

  const NormalSettings& settings() const noexcept { return settings_; }
  const PointCloud& cloud() const noexcept { return cloud_; }
  const NeighbourTree& tree() const noexcept { return tree_; }
  int size() const noexcept { return static_cast<int>(cloud_.points.size()); }
  void set_normals(std::vector<Eigen::Vector3d> normals) { cloud_.normals = std::move(normals); }

  // The nearest first. guess2: of Patch::reach2(), as of a point nearby.
  Patch nearest(const Eigen::Vector3d& p, int k, double guess2 = 0.0) const noexcept;
  // The same points in any order but for the last, and faster. `reach2`: Patch::reach2() at each
  // point of the cloud.
  Patch gathered(const Eigen::Vector3d& p, int k, const std::vector<double>& reach2) const noexcept;
  // The same points, the nearest first, found among those of the caller's last queries.
  Patch nearest(const Eigen::Vector3d& p, int k, RecentNeighbours* recent) const noexcept;

  // The patch's points relative to p, with their weights. False: they are too few.
  bool about(const Eigen::Vector3d& p, const Patch& patch, Neighbourhood* around) const noexcept;
  // From the closest point to the camera that saw it.
  Eigen::Vector3d towards_eye(const Patch& patch) const noexcept;
  // No surface where the points are too few.
  LocalSurface fit(const Eigen::Vector3d& p, const Patch& patch) const noexcept;

 private:
  NormalSettings settings_;
  PointCloud cloud_;
  NeighbourTree tree_;
};

inline SurfaceStatus status_of(const LocalSurface& surface, double max_one_sidedness) noexcept {
  if (!surface.is_surface) return SurfaceStatus::too_few;
  return surface.one_sidedness > max_one_sidedness ? SurfaceStatus::off_edge : SurfaceStatus::ok;
}

}  // namespace impedraw

// The seen surface as a plan may use it: as the widest patches see it, which is smooth, and finer
// where that is 0.5 mm off or more. It ends where the pen must not go: beside holes, steps and
// creases, where the fitted surface runs on beyond the points, and where it is rougher than
// `most_misfit`. Over two sheets a patch keeps to the nearer one.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "impedraw/perception/cloud_patches.h"
#include "impedraw/perception/normals.h"

namespace impedraw {

// estimate() is const, may run in any number of threads, and allocates nothing.
class PlanSurface {
 public:
  // `max_one_sidedness` replaces the setting of `seen`; most_misfit [m].
  PlanSurface(std::shared_ptr<const SurfaceEstimator> seen, double max_one_sidedness,
              double most_misfit = Roughness::kStepMisfit);

  // off_edge also where the pen must not go.
  SurfaceEstimate estimate(const Eigen::Vector3d& p_W) const noexcept;

  // The point of the cloud nearest to p_W lies in a crease, where two sides of the surface meet
  // like an open book. The tip touches both, and stands before the one that it moves towards.
  bool in_crease(const Eigen::Vector3d& p_W) const noexcept;

  const SurfaceEstimator& seen() const noexcept { return *seen_; }
  const PointCloud& cloud() const noexcept { return seen_->cloud(); }

 private:
  LocalSurface fit(const Eigen::Vector3d& p, const Patch& patch) const noexcept;
  void fit_one_sheet(const Eigen::Vector3d& towards, Neighbourhood* around,
                     LocalSurface* surface) const noexcept;
  void find_creases();
  void find_apart();
  void find_holes();
  bool is_hole(const Eigen::Vector3d& place) const noexcept;
  bool beside_hole(const Eigen::Vector3d& foot, const Eigen::Vector3d& n) const noexcept;
  bool ends_at(int point) const noexcept;

  std::shared_ptr<const SurfaceEstimator> seen_;
  const CloudPatches& patches_;
  const DetailLevels* levels_;  // null: there are no finer clouds
  double max_one_sidedness_;
  double most_misfit_;         // [m]
  std::vector<char> apart_;    // of each point: finer patches may be kLeastOff / 2 off nearby
  std::vector<char> creases_;  // of each point: within kCreaseMargin of one
  std::vector<Eigen::Vector3d> holes_;              // [m]
  std::unique_ptr<const NeighbourTree> hole_tree_;  // null: there are none
};

}  // namespace impedraw

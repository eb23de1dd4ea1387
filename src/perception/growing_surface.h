// The surface under the pen, built anew as frames improve what is known of it.
//
// A snapshot's surface is as noisy as its images. The model that later frames are fused into
// (surface_model.h) has less noise with each of them, and grows. So a second thread makes a
// SurfaceEstimator of its points, whenever they know clearly more than at the last time, and the
// control loop goes over to it without a step. Frames are coarse: where the snapshot saw the
// surface too rough for its own cloud (SurfaceEstimator::finer_share), its estimate stays. It also
// stays where the new one has none, so that nothing valid is forgotten.
//
// In lock-step a surface that was begun at time t appears at t + kBuilding, and update() waits for
// it then: a run does not depend on the machine. Else it appears when it is ready, update() never
// waits, and offer() may be called by another thread than update() and estimate().
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "impedraw/common/exchange.h"
#include "impedraw/control/surface_estimate.h"
#include "impedraw/perception/normals.h"
#include "impedraw/perception/surface_model.h"

namespace impedraw {

// The model's points as a cloud that normals are fitted to, weighted by what is known of them.
PointCloud cloud_of(std::span<const SurfaceModel::Point> points);

class GrowingSurface {
 public:
  static constexpr double kBuilding = 0.5;   // in lock-step [s]
  static constexpr double kGoingOver = 0.3;  // from one surface to the next [s]
  static constexpr double kPeriod = 1.0;     // at least, from one that was begun to the next [s]
  // A new one is begun when so much more is known in all, or so many more points are.
  static constexpr double kKnownMore = 1.5, kGrown = 1.02;

  // `snapshot` must outlive it. The new surfaces take `settings` too.
  GrowingSurface(const SurfaceEstimator& snapshot, const NormalSettings& settings, bool lock_step);
  ~GrowingSurface();
  GrowingSurface(const GrowingSurface&) = delete;
  GrowingSurface& operator=(const GrowingSurface&) = delete;

  // Begins a new surface where the model's points know enough more. After each frame. Allocates
  // only as their number grows.
  void offer(std::span<const SurfaceModel::Point> points, double time);
  // Takes a surface that is ready. Once per control step; allocates nothing.
  void update(double time) noexcept;

  // In the model's frame, as of the last update(). Allocates nothing.
  SurfaceEstimate estimate(const Eigen::Vector3d& p_K) const noexcept;

  int count() const noexcept { return count_; }  // of surfaces taken

 private:
  struct Surfaces {
    std::shared_ptr<const SurfaceEstimator> now, before;  // before: null at first, the snapshot's
  };
  void build_what_is_offered() noexcept;  // the second thread

  const SurfaceEstimator& snapshot_;
  NormalSettings settings_;
  bool lock_step_;

  // Written while nothing is being built, which posted_ == built_ tells.
  std::vector<SurfaceModel::Point> offered_;
  std::atomic<unsigned> posted_ = 0, built_ = 0;
  std::atomic<bool> ends_ = false;
  Latest<Surfaces> latest_;

  // State of offer(): start of the last [s], and the information at that time [1/m²].
  double begun_ = -1e9, known_ = 0.0;
  std::size_t points_ = 0;
  // State of update() [s].
  double now_ = 0.0, taken_ = -1e9;
  int count_ = 0;
  std::thread second_;
};

}  // namespace impedraw

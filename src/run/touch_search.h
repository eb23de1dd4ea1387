// The search for a surface that is found by touch, along one stroke after the other.
//
// A stroke is planned on a level, whose height is a guess. Once the pen is down, the plan is moved
// to where the tip is. Its clock waits while the pen searches. A search that takes longer than the
// approach over its whole way gives the stroke up.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/control_loop.h"
#include "impedraw/run/plan_clock.h"

namespace impedraw {

// Places where a drawing has touched its surface, so that the pen may come down fast elsewhere.
//
//   level(x, y) = min( top, min_i ( z_i + kMargin + kSteepest |p_i − (x, y)| ) )
//
// with the touched points i. It lies above a surface that is nowhere steeper than kSteepest from
// them on. Points are in the drawing frame P.

class TouchedHeights {
 public:
  static constexpr double kMargin = 5e-3;   // [m]
  static constexpr double kSteepest = 1.0;  // rise over run: 45°
  static constexpr double kSpacing = 2e-3;  // between kept points along the path [m]
  static constexpr std::size_t kMost = 50000;

  // top: no part of the surface is higher [m].
  explicit TouchedHeights(double top) : top_(top) { points_.reserve(kMost); }

  // Allocates nothing. Ignores points that are too near to the last one, or one too many.
  void add(const Eigen::Vector3d& p_P) noexcept {
    if (points_.size() == kMost) return;
    if (!points_.empty() && (points_.back() - p_P).head<2>().norm() < kSpacing) return;
    points_.push_back(p_P);
  }
  double level(double x, double y) const noexcept;
  std::size_t size() const { return points_.size(); }

 private:
  double top_;
  std::vector<Eigen::Vector3d> points_;
};

// Time limit for an approach to find the surface [s].
double longest_search(const ImpedanceSettings& control);

class TouchSearch {
 public:
  explicit TouchSearch(const Experiment& experiment);

  void begin_stroke() noexcept { height_ = searched_ = 0.0; }

  // The plan's reference, moved to the touched height. `mode`: of the last cycle.
  TipReference at_touched_height(TipReference reference, ContactMode mode,
                                 const Eigen::Vector3d& p_WE) noexcept;

  // After a cycle. False: there is no surface where it may be. `pen`: the deviation for the clock.
  bool update(const PathSample& desired, const ImpedanceTorque& out, const ControlLoop& loop,
              PenDeviation* pen) noexcept;

  const TouchedHeights& heights() const noexcept { return heights_; }

 private:
  const ImpedanceSettings& control_;
  Pose X_PW_;
  double lowest_;  // no part of the surface is lower, in P [m]
  TouchedHeights heights_;
  double height_ = 0.0;    // tip above the plan [m]
  double searched_ = 0.0;  // [s]
};

}  // namespace impedraw

// The search for a surface that is found by touch, along one stroke after the other.
//
// A stroke is planned on a level, whose height is a guess. Once the pen is down, the plan is moved
// to where the tip is. Its clock waits while the pen searches. A search that takes longer than the
// approach over its whole way gives the stroke up.
#pragma once

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/control_loop.h"
#include "impedraw/run/plan_clock.h"
#include "impedraw/run/touched_heights.h"

namespace impedraw {

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

// Notices places where a perceived surface does not let the pen pass as planned: a wall
// (wall_monitor.h), the foot of one (side_monitor.h), a gap into which the tip sinks
// (sink_monitor.h), a place without a surface, or one where the pen's shaft touches.
#pragma once

#include <optional>

#include "impedraw/experiment/experiment.h"
#include "impedraw/planning/stroke_part.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/side_monitor.h"
#include "impedraw/run/monitors/sink_monitor.h"
#include "impedraw/run/monitors/verdict.h"
#include "impedraw/run/monitors/wall_monitor.h"

namespace impedraw {

// The place on a stroke where the plan is, or that it has come down to; with `ahead`, the first
// point of the next stroke, too. planned: the plan's time [s].
std::optional<StrokePart> place_on_path(const PathSample& desired, const TipPath& path,
                                        double planned, bool ahead);

class BlockMonitor {
 public:
  explicit BlockMonitor(const Experiment& experiment);

  void begin_path() noexcept;

  // After each cycle in which the pen follows `path`. `unseen`: a place that the cameras do not
  // resolve was felt (rattle_monitor.h). A verdict comes with the place.
  Verdict judge(const Cycle& cycle, const TipPath& path, double planned, bool unseen,
                std::optional<StrokePart>* place);

  // Both need perception and a measured wrench.
  bool feels() const noexcept { return feels_; }

 private:
  bool sinks(const Cycle& cycle) noexcept;
  bool lost_surface(const Cycle& cycle) noexcept;

  const SurfaceEstimator* surface_;  // null: not perceived
  bool feels_;
  double touch_force_;  // [N]
  WallMonitor wall_;
  SideMonitor side_;
  SinkMonitor sink_;
  // Below the estimated surface, where a stroke has touched nothing yet; before the run's first
  // touch, as far as cameras that agree may err together [m].
  double deepest_;
  StrokePart touched_{-1, 0.0, 0.0};  // where the surface held the tip last
  bool retreats_ = false;             // the controller, in the cycle before
};

}  // namespace impedraw

// Sources of the control loop: the perceived surface, and the motion of the canvas.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "impedraw/experiment/experiment.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/run/canvas_watch.h"
#include "impedraw/run/control_loop.h"

namespace impedraw {

// The disturbances of a scenario, at fractions of the plan's time: pushes on the pen and on
// links of the arm, and faults.

// The time at `share` of the interval from the first stroke's start to the last stroke's end [s].
double time_at(const TipPath& path, double share);

struct LinkPush {
  std::string link;
  Eigen::Vector3d force_W;  // at the link's origin [N]
  double start, end;        // [s]

  bool acts(double time) const noexcept { return time >= start && time < end; }
};

class Disturbances {
 public:
  Disturbances() = default;  // none
  Disturbances(const Scenario& scenario, const TipPath& path);
  // One push on the pen about the time `middle` [s].
  Disturbances(const PushSettings& push, double middle) : pushes_{{push, middle}} {}

  bool fault(FaultKind kind, double time) const noexcept { return since(kind, time) >= 0.0; }
  // Time for which the fault has acted [s]; negative: it does not.
  double since(FaultKind kind, double time) const noexcept;
  const std::vector<LinkPush>& link_pushes() const noexcept { return link_pushes_; }
  bool any_push() const noexcept { return !pushes_.empty(); }
  // Force on the pen where the canvas has the normal n_W [N].
  Eigen::Vector3d push(double time, const Eigen::Vector3d& n_W) const noexcept;

 private:
  struct TimedFault {
    FaultKind kind;
    double start, end;  // [s]
  };
  struct TimedPush {
    PushSettings push;
    double middle;  // [s]
  };
  std::vector<TimedFault> faults_;
  std::vector<TimedPush> pushes_;  // on the pen
  std::vector<LinkPush> link_pushes_;
};

// True if the plan follows a canvas that may move.
bool follows_canvas(const Experiment& experiment, const Driver& driver);

// The scenario's disturbances: they occur in the first run only, not in a resumed one.
Disturbances disturbances_of(const Experiment& experiment, bool resumed);

// The cameras that keep capturing; null where none does. X_WK: of the canvas, when the run begins.
std::unique_ptr<CanvasWatch> canvas_watch(const Experiment& experiment, Driver& driver,
                                          const Pose& X_WK);

// The perceived surface, without that which the scenario's faults hide; empty without perception.
// growing: null where the surface stays as the snapshot saw it.
SurfaceSource surface_source(const Experiment& experiment, Disturbances disturbances,
                             const GrowingSurface* growing);

// The canvas by the cameras or, where there is no watch, by its true motion; empty where it stands.
CanvasSource canvas_source(const Experiment& experiment, CanvasWatch* watch, const Driver& driver);

}  // namespace impedraw

// The disturbances of a scenario, at fractions of the plan's time: pushes on the pen and on
// links of the arm, and faults.
#pragma once

#include <string>
#include <vector>

#include "impedraw/experiment/faults.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/planning/path/tip_path.h"

namespace impedraw {

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

}  // namespace impedraw

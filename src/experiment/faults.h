// What goes wrong in a loop around the controller: put on purpose, to see what the arm then does.
#pragma once

#include <vector>

namespace impedraw {

enum class FaultKind {
  nan_state,     // a joint's velocity is not a number
  stale_state,   // the joints are read as they were when the fault began
  nan_wrench,    // the wrench is not a number
  stale_wrench,  // it stays as it was
  no_cloud,      // perception has no surface under the tip
  slow_step,     // the controller's step takes that long; the drives hold the last torque
};

struct FaultSettings {
  FaultKind kind = FaultKind::nan_state;
  // when it begins: share of the time from the first stroke's start to the last one's end
  double start = 0.5;
  double duration = 0.05;  // [s]
};

}  // namespace impedraw

// Faults injected into the loop around the controller, to test how the arm reacts.
#pragma once

namespace impedraw {

enum class FaultKind {
  nan_state,     // a joint velocity is NaN
  stale_state,   // the joint state stays as it was when the fault began
  nan_wrench,    // the wrench is NaN
  stale_wrench,  // the wrench stays as it was when the fault began
  no_cloud,      // perception finds no surface under the tip
  no_frames,     // the cameras' frames of a moving canvas get lost
  slow_step,     // one control step takes `duration`; the drives hold the last torque
  // An arm and a sensor that lie:
  jumped_state,    // the first joint's position is 0.5 rad off
  drifting_state,  // the first joint's position drifts by 0.3 rad/s, which its speed does not tell
  standing_state,  // positions as they were when the fault began, speeds zero
  false_speed,     // the first joint's speed is 9 rad/s
  false_wrench,    // 200 N more along z
  future_wrench,   // the wrench is stamped an hour ahead
};

struct FaultSettings {
  FaultKind kind = FaultKind::nan_state;
  // Start, as a fraction of the time from the first stroke's start to the last stroke's end.
  double start = 0.5;
  double duration = 0.05;  // [s]
};

}  // namespace impedraw

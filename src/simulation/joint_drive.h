// What becomes of a torque on its way from the controller to the joints: late, in steps, with
// ripple (model_errors.h has the formula).
#pragma once

#include <array>

#include "impedraw/control/arm_terms.h"
#include "impedraw/simulation/model_errors.h"

namespace impedraw {

class JointDrive {
 public:
  // Throws InputError for a delay, quantum or ripple out of range.
  JointDrive(const ModelErrors& errors, double dt);

  void reset() noexcept;  // the next command is the first again

  // The torque that acts at joint position q when `command` is the newest one.
  JointVector act(const JointVector& command, const JointVector& q) noexcept;

 private:
  ModelErrors errors_;
  JointVector ripple_phase_;                                         // of kMaxJoints
  std::array<JointVector, ModelErrors::kMostDelaySteps> under_way_;  // a ring of delay_ commands
  int delay_ = 0;                                                    // [steps]
  int oldest_ = 0;
  bool started_ = false;
};

}  // namespace impedraw

// Joint drives: delay, quantisation and ripple of the commanded torque. Formula: ModelErrors.
#pragma once

#include <array>

#include "impedraw/control/arm_terms.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

class JointDrive {
 public:
  // Throws InputError for a delay, quantum or ripple out of range.
  JointDrive(const ModelErrors& errors, double dt);

  void reset() noexcept;  // forgets past commands

  // Returns the torque that acts at joint position q, given the newest command.
  JointVector act(const JointVector& command, const JointVector& q) noexcept;

 private:
  ModelErrors errors_;
  JointVector ripple_phase_;                                         // of kMaxJoints
  std::array<JointVector, ModelErrors::kMostDelaySteps> under_way_;  // ring of delay_ commands
  int delay_ = 0;                                                    // [steps]
  int oldest_ = 0;
  bool started_ = false;
};

}  // namespace impedraw

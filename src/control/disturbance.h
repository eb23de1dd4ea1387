// Torque against what the arm's model does not explain: the observer's estimate, and the share of
// it that the law compensates.
//
// Law      r_y = r_c + Jᵀ J̄ᵀ (r − r_c),  r_c: r within ± (yield_limit + 0.12 |g|) of each joint
//          r: momentum_observer.h. Dry friction and wrong masses are compensated whole. Beyond
//          that only the part at the tip is: a push on the arm's body moves the arm through its
//          null space.
// Requires a measured wrench; `space` updated for `arm`
#pragma once

#include "impedraw/control/momentum_observer.h"
#include "impedraw/control/step_input.h"

namespace impedraw {

class Disturbance {
 public:
  static constexpr double kWeightShare = 0.12;  // what wrong masses add to r, per weight torque

  // Throws InputError if a delay exceeds the observer's history.
  Disturbance(const ImpedanceSettings& settings, int joints);

  // Updates r and returns −r_y [Nm], 0 without a measured wrench or an observer. While the wrench
  // is lost r is held: the wrench would have to be subtracted.
  JointVector compensation(const StepInput& in, const OperationalSpace& space) noexcept;
  // The torque that was commanded in this step [Nm].
  void commanded(const StepInput& in, const JointVector& tau) noexcept;
  void reset() noexcept { observer_.reset(); }

 private:
  bool observed_;
  JointVector yield_limit_;  // [Nm]; empty: none
  MomentumObserver observer_;
};

// r_y of r. most: bound of each |r_c| [Nm].
JointVector yielding(const JointVector& r, const JointVector& most, const ArmTerms& arm,
                     const OperationalSpace& space) noexcept;

}  // namespace impedraw

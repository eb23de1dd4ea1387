// Forecast of the joints' speeds along a planned path, as a limit on the plan's clock.
//
// The planner times strokes by the joints' limits (joint_rates.h), but the ways between strokes by
// tip speed and turning alone: near a singular posture a slow turn of the pen is a fast one of two
// joints. Before the path is followed, the postures along it are integrated with the least kinetic
// energy, as under the controller. Where a joint would exceed `share` of its speed limit, the clock
// may run at most so fast that it does not.
#pragma once

#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/planning/path/tip_path.h"

namespace impedraw {

class JointForecast {
 public:
  JointForecast() = default;
  // From posture q at the beginning of the path. rest_q: the null space's.
  JointForecast(ArmModel arm, const TipPath& path, const JointVector& q, const JointVector& rest_q,
                double share);

  // Greatest rate of the clock at the plan's time t, 0 … 1: the least from t to kAhead later.
  double limit(double t) const noexcept;

 private:
  static constexpr double kStep = 0.02, kAhead = 0.3;  // [s]
  std::vector<float> limits_;
};

}  // namespace impedraw

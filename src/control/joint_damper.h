// Damps each joint that is faster than its limit, as much as the sampled loop bears. It only takes
// energy. Near a singularity the joint speeds needed for a given tip speed change faster than the
// joints can.
//
// Law      τ_j = −c (|v_j| − most_j)/(M⁻¹)_jj sign(v_j)  where |v_j| > most_j
//          most: JointRange::most_speed; c: bearable_rate of damping.h
// Requires `space` updated for `arm`
#pragma once

#include <cmath>

#include "impedraw/control/damping.h"
#include "impedraw/control/joint_range.h"

namespace impedraw {

class JointDamper {
 public:
  explicit JointDamper(const ImpedanceSettings& settings)
      : rate_(bearable_rate(settings.timing.damping_delay())) {}

  // [Nm]
  JointVector torque(const ArmTerms& arm, const OperationalSpace& space,
                     const JointRange& range) noexcept {
    JointVector tau = JointVector::Zero(arm.v.size());
    active_ = false;
    for (Eigen::Index j = 0; j < range.speeds(); ++j) {
      const double over = std::abs(arm.v[j]) - range.most_speed(arm.q, j, arm.v[j]);
      if (over <= 0.0) continue;
      active_ = true;
      const double lightness = space.acceleration(JointVector::Unit(tau.size(), j))[j];
      tau[j] = -std::copysign(rate_ * over / lightness, arm.v[j]);
    }
    return tau;
  }
  bool active() const noexcept { return active_; }  // a joint was damped in the last step

 private:
  double rate_;  // c [1/s]
  bool active_ = false;
};

}  // namespace impedraw

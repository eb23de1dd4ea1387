// Torque against what the arm's model does not explain: the observer's estimate, and the share of
// it that the law compensates.
//
// Law      r_y = r_c + Jᵀ J̄ᵀ (r − r_c),  r_c: r within ± (yield_limit + 0.12 |g|) of each joint
//          r: momentum_observer.h. Dry friction and wrong masses are compensated whole. Beyond
//          that only the part at the tip is: a push on the arm's body moves the arm through its
//          null space.
// Requires a measured wrench; `space` updated for `arm`
#pragma once

#include <algorithm>

#include "impedraw/control/momentum_observer.h"
#include "impedraw/control/step_input.h"

namespace impedraw {

// r_y of r. most: bound of each |r_c| [Nm].
inline JointVector yielding(const JointVector& r, const JointVector& most, const ArmTerms& arm,
                            const OperationalSpace& space) noexcept {
  if ((r.cwiseAbs() - most).maxCoeff() <= 0.0) return r;
  const JointVector within = r.cwiseMin(most).cwiseMax(-most);
  return within + arm.J.transpose().lazyProduct(space.project_to_tip(r - within));
}

class Disturbance {
 public:
  static constexpr double kWeightShare = 0.12;  // what wrong masses add to r, per weight torque

  // Throws InputError if a delay exceeds the observer's history.
  Disturbance(const ImpedanceSettings& s, int joints)
      : observed_(s.wrench == WrenchFeedback::measured && s.observer.enabled),
        yield_limit_(Eigen::Map<const Eigen::VectorXd>(
            s.observer.yield_limit.data(),
            static_cast<Eigen::Index>(s.observer.yield_limit.size()))),
        observer_(s.observer, joints, s.timing.dt,
                  std::max(0.0, s.timing.wrench_delay - s.timing.dt - s.timing.velocity_age),
                  s.timing.torque_delay() + s.timing.velocity_age) {}

  // Updates r and returns −r_y [Nm], 0 without a measured wrench or an observer. While the wrench
  // is lost r is held: the wrench would have to be subtracted.
  JointVector compensation(const StepInput& in, const OperationalSpace& space) noexcept {
    if (!observed_) return JointVector::Zero(in.arm.q.size());
    if (in.wrench_lost)
      observer_.pause();
    else
      observer_.update(in.arm, in.F_ext);
    const JointVector& r = observer_.disturbance();
    if (yield_limit_.size() == 0) return -r;
    return -yielding(r, yield_limit_ + kWeightShare * in.arm.g.cwiseAbs(), in.arm, space);
  }
  // The torque that was commanded in this step [Nm].
  void commanded(const StepInput& in, const JointVector& tau) noexcept {
    if (observed_ && !in.wrench_lost) observer_.commanded(tau);
  }
  void reset() noexcept { observer_.reset(); }

 private:
  bool observed_;
  JointVector yield_limit_;  // [Nm]; empty: none
  MomentumObserver observer_;
};

}  // namespace impedraw

#include "impedraw/control/disturbance.h"

#include <algorithm>

namespace impedraw {

JointVector yielding(const JointVector& r, const JointVector& most, const ArmTerms& arm,
                     const OperationalSpace& space) noexcept {
  if ((r.cwiseAbs() - most).maxCoeff() <= 0.0) return r;
  const JointVector within = r.cwiseMin(most).cwiseMax(-most);
  return within + arm.J.transpose().lazyProduct(space.project_to_tip(r - within));
}

Disturbance::Disturbance(const ImpedanceSettings& s, int joints)
    : observed_(s.wrench == WrenchFeedback::measured && s.observer.enabled),
      yield_limit_(Eigen::Map<const Eigen::VectorXd>(
          s.observer.yield_limit.data(), static_cast<Eigen::Index>(s.observer.yield_limit.size()))),
      observer_(s.observer, joints, s.timing.dt,
                std::max(0.0, s.timing.wrench_delay - s.timing.dt - s.timing.velocity_age),
                s.timing.torque_delay() + s.timing.velocity_age) {}

JointVector Disturbance::compensation(const StepInput& in, const OperationalSpace& space) noexcept {
  if (!observed_) return JointVector::Zero(in.arm.q.size());
  if (in.wrench_lost)
    observer_.pause();
  else
    observer_.update(in.arm, in.F_ext);
  const JointVector& r = observer_.disturbance();
  if (yield_limit_.size() == 0) return -r;
  return -yielding(r, yield_limit_ + kWeightShare * in.arm.g.cwiseAbs(), in.arm, space);
}

void Disturbance::commanded(const StepInput& in, const JointVector& tau) noexcept {
  if (observed_ && !in.wrench_lost) observer_.commanded(tau);
}

}  // namespace impedraw

#include "impedraw/control/joint_brake.h"

#include <algorithm>
#include <cmath>

#include "impedraw/control/damping.h"

namespace impedraw {

JointBrake::JointBrake(const ImpedanceSettings& s, int joints)
    : dt_(s.timing.dt),
      damping_rate_(bearable_rate(s.timing.damping_delay())),
      torque_rate_(s.limits.torque_rate),
      behind_(JointVector::Zero(joints)) {}

JointVector JointBrake::torque(const ArmTerms& arm, const OperationalSpace& space,
                               const Eigen::Vector3d& v_WD) noexcept {
  Vector6 V_D;
  V_D << v_WD, Eigen::Vector3d::Zero();
  const JointVector v_D =
      space.acceleration(arm.J.transpose().lazyProduct(Vector6(space.inertia() * V_D)));
  const JointVector lack = v_D - arm.v;
  behind_ += dt_ * lack;
  behind_ = behind_.cwiseMax(-kFurthest).cwiseMin(kFurthest);
  JointVector tau(lack.size());
  for (Eigen::Index j = 0; j < tau.size(); ++j) {
    const double M = arm.M(j, j);
    double D = damping_rate_ / space.acceleration(JointVector::Unit(tau.size(), j))[j];
    if (torque_rate_.size() > 0) D = std::min(D, std::sqrt(kShare * torque_rate_[j] / kFast * M));
    tau[j] = D * lack[j] + 0.25 * D * D / M * behind_[j];
  }
  return tau;
}

}  // namespace impedraw

#include "impedraw/control/null_space.h"

#include <algorithm>
#include <cmath>

#include "impedraw/control/damping.h"

namespace impedraw {
namespace {

constexpr double kNoSelfMotion = 1e-12;  // of six joints: zᵀ M z [kg m²/s⁴]

// (I − Jᵀ J̄ᵀ) τ
JointVector projected(const ArmTerms& arm, const OperationalSpace& space,
                      const JointVector& tau) noexcept {
  return tau - arm.J.transpose().lazyProduct(space.project_to_tip(tau));
}

}  // namespace

NullSpace::NullSpace(const ImpedanceSettings& s)
    : stiffness_(s.null_space.stiffness),
      q_0_(s.null_space.q_0),
      damping_ratio_(s.null_space.damping_ratio),
      range_torque_(s.joint_range.torque),
      joint_speed_(s.limits.joint_speed),
      damping_delay_(s.timing.damping_delay()) {}

JointVector NullSpace::torque(const ArmTerms& arm, const OperationalSpace& space,
                              const JointRange& range) noexcept {
  return projected(arm, space, unprojected(arm, space, range));
}

JointVector NullSpace::unprojected(const ArmTerms& arm, const OperationalSpace& space,
                                   const JointRange& range) noexcept {
  const JointVector D_q =
      2.0 * damping_ratio_ * stiffness_.cwiseProduct(arm.M.diagonal()).cwiseSqrt();
  const JointVector pull = stiffness_.cwiseProduct(q_0_ - arm.q);
  const double speed = arm.v.cwiseAbs().maxCoeff();
  const double fast = speed / kSelfMotionSpeed - 1.0;
  const double along = pull.dot(arm.v) / (kAlong * pull.norm() * arm.v.norm() + 1e-12);
  double share = 1.0 - std::clamp(fast, 0.0, 1.0) * std::clamp(along, 0.0, 1.0);
  double damping = 1.0 + kMoreDamping * std::clamp(speed / kCalmSpeed - 1.0, 0.0, 1.0);
  const auto rate = [&](const JointVector& u) {
    return u.dot(D_q.cwiseProduct(u)) / u.dot(arm.M * u);
  };
  if (damping > 1.0) {
    const double own = rate(arm.v - space.joint_speed(arm.V_WE));
    if (own > 0.0) damping = std::clamp(bearable_rate(damping_delay_) / own, 1.0, damping);
  }
  const JointVector z = space.acceleration(projected(arm, space, pull));
  if (z.dot(arm.M * z) > kNoSelfMotion) {
    const double most = 1.0 / damping_delay_;
    damping = std::min(damping, most / rate(z));
    for (Eigen::Index j = 0; j < joint_speed_.size(); ++j)
      share = std::min(share, joint_speed_[j] * most / std::abs(z[j]));
  }
  return share * pull - damping * D_q.cwiseProduct(arm.v) + range_torque(arm.q, range);
}

// τ_limit
JointVector NullSpace::range_torque(const JointVector& q, const JointRange& range) noexcept {
  JointVector tau = JointVector::Zero(q.size());
  near_range_end_ = false;
  for (Eigen::Index j = 0; j < range.ranges(); ++j) {
    const JointRange::Depth depth = range.depth(q, j);
    const double into = std::max(depth.lower, depth.upper);
    if (into == 0.0) continue;
    near_range_end_ = true;
    tau[j] = (depth.lower > depth.upper ? 1.0 : -1.0) * range_torque_ * into * into;
  }
  return tau;
}

}  // namespace impedraw

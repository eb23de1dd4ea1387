#include "impedraw/control/speed_limit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace impedraw {

void keep_joint_speeds(const ArmTerms& arm, const OperationalSpace& space, const JointRange& range,
                       Vector6* V) noexcept {
  const Eigen::Index n = range.speeds();
  if (n == 0) return;
  TwoVelocities apart = TwoVelocities::Zero();  // the turn alone; the rest, less what the tip does
  apart.col(0).tail<3>() = V->tail<3>();
  apart.col(1).head<3>() = V->head<3>();
  apart.col(1) -= arm.V_WE;
  const TwoJointSpeeds change = space.joint_speeds(apart);
  const auto by_turn = change.col(0);
  const JointVector without_turn = arm.v + change.col(1);
  // the largest share of `by` that keeps joint j within its limit
  const auto share = [&](Eigen::Index j, double other, double by) {
    const double way = std::copysign(1.0, by), most = range.most_speed(arm.q, j, by);
    if (by == 0.0 || way * other + std::abs(by) <= most) return 1.0;
    return std::max(0.0, (most - way * other) / std::abs(by));
  };
  double turn = 1.0, both = 1.0;
  for (Eigen::Index j = 0; j < n; ++j) turn = std::min(turn, share(j, without_turn[j], by_turn[j]));
  V->tail<3>() *= turn;
  const JointVector v = without_turn + turn * by_turn;
  bool fast = false;
  for (Eigen::Index j = 0; j < n; ++j) fast |= std::abs(v[j]) > range.most_speed(arm.q, j, v[j]);
  if (!fast) return;
  const JointVector by_tip = space.joint_speed(*V);
  for (Eigen::Index j = 0; j < n; ++j) both = std::min(both, share(j, v[j] - by_tip[j], by_tip[j]));
  *V *= both;
}

bool SpeedLimit::is_slow(const ArmTerms& arm, const TipImpedance& impedance,
                         const JointRange& range, const TipTarget& d) const noexcept {
  const bool joints = range.speeds() > 0;
  if (joints && range.room(arm.q) < kNearEnd) return false;
  const double any = std::numeric_limits<double>::infinity();
  const double slow = std::min(joints ? kSlow : any, kSlowShare * limits_.tip_speed);
  const double turns_slowly = std::min(joints ? kSlow : any, kSlowShare * limits_.turn_speed);
  const double small_pull = kSmallError * impedance.stiffness().linear.tangent;
  const double small_turn =
      (joints ? kSmallAngleOfJoints : kSmallAngle) * impedance.stiffness().angular.tangent;
  return d.V.head<3>().squaredNorm() <= slow * slow &&
         d.V.tail<3>().squaredNorm() <= turns_slowly * turns_slowly &&
         d.Ke.head<3>().squaredNorm() <= small_pull * small_pull &&
         d.Ke.tail<3>().squaredNorm() <= small_turn * small_turn;
}

bool SpeedLimit::apply(const ArmTerms& arm, const OperationalSpace& space,
                       const TipImpedance& impedance, const JointRange& range,
                       TipTarget* target) const noexcept {
  if (is_slow(arm, impedance, range, *target)) return false;
  Vector6 V_end = target->V + impedance.follow(target->Ke);
  const double speed = V_end.head<3>().norm(), turn = V_end.tail<3>().norm();
  // scale both parts: a coupled inertia would turn the remaining rotation into speed
  V_end *= std::min(limits_.tip_speed / std::max(speed, limits_.tip_speed),
                    limits_.turn_speed / std::max(turn, limits_.turn_speed));
  keep_joint_speeds(arm, space, range, &V_end);
  const double slower = 1.0 - V_end.head<3>().norm() / std::max(speed, 1e-9),
               turns_slower = 1.0 - V_end.tail<3>().norm() / std::max(turn, 1e-9);
  if (!(slower > 0.0 || turns_slower > 0.0)) return false;
  const auto hold_back = [](double by, auto a, const Eigen::Vector3d& along) {
    a -= std::min(1.0, kHoldBack * by) * std::max(0.0, a.dot(along)) * along;
  };
  hold_back(slower, target->Vdot.head<3>(), V_end.head<3>().normalized());
  hold_back(turns_slower, target->Vdot.tail<3>(), V_end.tail<3>().normalized());
  target->V = V_end;
  target->Ke.setZero();
  return true;
}

}  // namespace impedraw

// Takes the energy out of a motion that the law of impedance.h no longer controls, with nothing
// that the law needs: no wrench, no observer, no shaped inertia. A second control law, for the loop
// that calls to choose.
//
// Law      τ = g + (α M + D) (v_D − v) + (α²/4) M ∫(v_D − v) dt
//          D diagonal, D_j = min(c/(M⁻¹)_jj, α_j M_jj),  α = the least of α_j
//          c: bearable_rate of damping.h
//          α_j = min(c, √(0.3 τ̇_j / (2 rad/s · M_jj))), τ̇: the torque's rate limit, within which
//          the torque of 2 rad/s builds up in 0.3 of the braking time
//          v_D = J̄ V_D: zero, or the motion of least energy with the tip's velocity
//          D brings light joints to rest; α M also those that turn together, whose inertia is many
//          times what each has alone. Both are positive definite, so that no error of M adds
//          energy.
//          The integral, of at most 0.5 rad, holds against friction and a hand. It is emptied once,
//          where the motion turns back, 2/α from the beginning at the latest: the arm stays there
//          (a reset integrator: Clegg, A nonlinear integrator for servomechanisms, 1958).
// Requires `space` updated for `arm`
#pragma once

#include <algorithm>
#include <cmath>

#include "impedraw/control/damping.h"
#include "impedraw/control/impedance_settings.h"

namespace impedraw {

class JointBrake {
 public:
  static constexpr double kFast = 2.0;      // speed from which to brake [rad/s]
  static constexpr double kShare = 0.3;     // share of the braking time for the torque to build up
  static constexpr double kFurthest = 0.5;  // bound of the integral [rad]

  JointBrake(const ImpedanceSettings& s, int joints)
      : dt_(s.timing.dt),
        damping_rate_(bearable_rate(s.timing.damping_delay())),
        torque_rate_(s.limits.torque_rate),
        behind_(JointVector::Zero(joints)) {}

  // τ − g [Nm] of one step; v_WD: desired velocity of the tip [m/s].
  JointVector torque(const ArmTerms& arm, const OperationalSpace& space,
                     const Eigen::Vector3d& v_WD) noexcept {
    Vector6 V_D;
    V_D << v_WD, Eigen::Vector3d::Zero();
    const JointVector v_D =
        space.acceleration(arm.J.transpose().lazyProduct(Vector6(space.inertia() * V_D)));
    const JointVector lack = v_D - arm.v;
    const JointVector momentum = arm.M.lazyProduct(lack);
    if (!turned_ && v_WD.isZero(0.0) && momentum.dot(behind_) < 0.0) {
      turned_ = true;
      behind_.setZero();
    }
    behind_ += dt_ * lack;
    behind_ = behind_.cwiseMax(-kFurthest).cwiseMin(kFurthest);
    const JointVector rate = rates(arm.M);
    const double alpha = rate.minCoeff();
    JointVector tau = alpha * momentum + 0.25 * alpha * alpha * arm.M.lazyProduct(behind_);
    for (Eigen::Index j = 0; j < tau.size(); ++j) {
      const double alone = 1.0 / space.acceleration(JointVector::Unit(tau.size(), j))[j];
      tau[j] += std::min(damping_rate_ * alone, rate[j] * arm.M(j, j)) * lack[j];
    }
    return tau;
  }
  void release() noexcept {  // the next step begins a new braking
    behind_.setZero();
    turned_ = false;
  }

 private:
  // α_j, at most c [1/s]
  JointVector rates(const JointMatrix& M) const noexcept {
    JointVector rate = JointVector::Constant(M.rows(), damping_rate_);
    for (Eigen::Index j = 0; j < torque_rate_.size(); ++j)
      rate[j] = std::min(rate[j], std::sqrt(kShare * torque_rate_[j] / kFast / M(j, j)));
    return rate;
  }

  double dt_, damping_rate_;
  JointVector torque_rate_;  // [Nm/s]; empty: no limit
  JointVector behind_;       // ∫(v_D − v) dt [rad]
  bool turned_ = false;
};

}  // namespace impedraw

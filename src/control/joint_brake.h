// Takes the energy out of a motion that the law of impedance.h no longer controls, with nothing
// that the law needs: no wrench, no observer, no shaped inertia. A second control law, for the loop
// that calls to choose.
//
// Law      τ = g + D (v_D − v) + K ∫(v_D − v) dt
//          D and K are diagonal, so that no error of M adds energy.
//          D_j = min(c/(M⁻¹)_jj, √(0.3 τ̇_j M_jj / 2 rad/s)),  K_j = D_j²/(4 M_jj)
//          c: bearable_rate of damping.h; τ̇: the torque's rate limit, within which the torque of
//          D at 2 rad/s builds up in 0.3 of the braking time
//          v_D = J̄ V_D: zero, or the motion of least energy with the tip's velocity
//          The integral, of at most 0.5 rad, holds against friction and a hand.
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
  void release() noexcept { behind_.setZero(); }  // the next step begins a new braking

 private:
  double dt_, damping_rate_;
  JointVector torque_rate_;  // [Nm/s]; empty: no limit
  JointVector behind_;       // ∫(v_D − v) dt [rad]
};

}  // namespace impedraw

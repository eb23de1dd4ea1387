#include "impedraw/control/momentum_observer.h"

#include <cmath>
#include <string>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/control/describe_control.h"

namespace impedraw {

void ObserverSettings::validate() const { require_ranges("control.observer", *this); }

MomentumObserver::MomentumObserver(const ObserverSettings& settings, int joints, double dt,
                                   double wrench_age, double torque_delay)
    : settings_(settings),
      dt_(dt),
      gain_(1.0 - std::exp(-settings.bandwidth * dt)),
      wrench_steps_(static_cast<int>(std::lround(wrench_age / dt))),
      torque_steps_(static_cast<int>(std::lround(torque_delay / dt))),
      M_(JointMatrix::Zero(joints, joints)),
      v_(JointVector::Zero(joints)),
      bias_(JointVector::Zero(joints)),
      r_(JointVector::Zero(joints)) {
  const auto in_range = [](int steps) { return steps >= 0 && steps < kHistory - 1; };
  settings.validate();
  if (!in_range(wrench_steps_) || !in_range(torque_steps_))
    throw InputError("observer: the wrench's age and the torque's delay are " +
                     std::to_string(1e3 * wrench_age) + " and " +
                     std::to_string(1e3 * torque_delay) + " ms; valid are 0 to " +
                     std::to_string(1e3 * dt * (kHistory - 2)) + " ms");
  unexplained_.fill(r_);
  tau_.fill(r_);
}

void MomentumObserver::reset() noexcept {
  step_ = 0;
  r_.setZero();
}

const JointVector& MomentumObserver::update(const ArmTerms& arm, const Vector6& F_ext) noexcept {
  if (step_ > torque_steps_) {
    const JointVector& tau = tau_[(step_ - 1 - torque_steps_) % kHistory];
    const JointVector dv = arm.v - v_;
    unexplained_[(step_ - 1) % kHistory] = M_.lazyProduct(dv) / dt_ + bias_ - tau;
    if (step_ > torque_steps_ + wrench_steps_) {
      const JointVector d = unexplained_[(step_ - 1 - wrench_steps_) % kHistory] -
                            arm.J.transpose().lazyProduct(F_ext);
      r_ += gain_ * (d - r_);
      r_ = r_.cwiseMin(settings_.limit).cwiseMax(-settings_.limit);
    }
  }
  M_ = arm.M;
  v_ = arm.v;
  bias_ = arm.Cv + arm.g;
  return r_;
}

void MomentumObserver::commanded(const JointVector& tau) noexcept {
  tau_[step_ % kHistory] = tau;
  ++step_;
}

}  // namespace impedraw

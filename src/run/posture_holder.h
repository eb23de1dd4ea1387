// Holds an arm by joint stiffness plus modelled gravity about the posture in which it stands, or a
// posture near it.
#pragma once

#include <stdexcept>

#include <Eigen/Cholesky>

#include "impedraw/arm/arm_model.h"
#include "impedraw/run/driver.h"

namespace impedraw {

class PostureHolder {
 public:
  // delay: the longest that the loop may have [s]. A light joint gets less stiffness: through the
  // delay it would oscillate.
  PostureHolder(const ArmModel& arm, Driver& driver, double delay)
      : arm_(arm), driver_(driver), terms_(arm.joints()), state_(&driver.read()), q0_(state_->q) {
    arm_.compute(q0_, state_->v, &terms_);
    const JointMatrix inverse =
        terms_.M.ldlt().solve(JointMatrix::Identity(terms_.M.rows(), terms_.M.cols()));
    const JointVector inertia = inverse.diagonal().cwiseInverse();
    const double bandwidth = kPhase / delay;
    stiffness_ = (bandwidth * bandwidth * inertia).cwiseMin(kMostStiffness);
    damping_ = 1.4 * stiffness_.cwiseProduct(inertia).cwiseSqrt();
  }

  // One cycle towards (q_d, v_d), with a torque added. Returns what was commanded beyond gravity.
  JointVector step(const JointVector& q_d, const JointVector& v_d, const JointVector& added) {
    arm_.compute(state_->q, state_->v, &terms_);
    JointVector tau =
        stiffness_.cwiseProduct(q_d - state_->q) + damping_.cwiseProduct(v_d - state_->v) + added;
    tau = tau.cwiseMin(arm_.limits().torque).cwiseMax(-arm_.limits().torque);
    driver_.command(terms_.g + tau, terms_.g);
    state_ = &driver_.read();
    if (!driver_.fault().empty()) throw std::runtime_error(driver_.fault());
    return tau;
  }
  const JointVector& start() const { return q0_; }
  const ArmState& state() const { return *state_; }
  const ArmTerms& terms() const { return terms_; }

 private:
  static constexpr double kMostStiffness = 300.0;  // of each joint [Nm/rad]
  static constexpr double kPhase = 0.35;  // bandwidth of a joint's stiffness times the loop's delay

  ArmModel arm_;
  Driver& driver_;
  ArmTerms terms_;
  const ArmState* state_;
  JointVector q0_, stiffness_, damping_;
};

}  // namespace impedraw

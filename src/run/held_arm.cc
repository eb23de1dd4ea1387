#include "impedraw/run/held_arm.h"

#include "impedraw/run/motion_check.h"
#include "impedraw/run/real_time.h"

namespace impedraw {

HeldArm::HeldArm(Driver& driver, const ArmModel& arm, const ArmState* state)
    : driver_(driver),
      arm_(arm),
      terms_(arm.joints()),
      state_(state ? state : &driver.read()),
      q_0_(state_->q) {
  failed_ = !driver_.fault().empty();
  thread_ = std::thread([this] { answer(); });
  schedule_alike(&thread_);
}

void HeldArm::answer() noexcept {
  const double stiffness = driver_.info().velocity ? 0.25 * kDampRate * kDampRate : 0.0;  // [1/s²]
  while (!ends_ && !failed_) {
    arm_.compute(state_->q, state_->v, &terms_);
    const JointVector away = (q_0_ - state_->q).cwiseMax(-kMostSpring).cwiseMin(kMostSpring);
    driver_.command(
        terms_.g + damping_torque(terms_.M, state_->v) + stiffness * terms_.M.lazyProduct(away),
        terms_.g);
    state_ = &driver_.read();
    failed_ = !driver_.fault().empty();
  }
}

const ArmState* HeldArm::release() {
  ends_ = true;
  if (thread_.joinable()) thread_.join();
  return state_;
}

}  // namespace impedraw

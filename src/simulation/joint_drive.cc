#include "impedraw/simulation/joint_drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "impedraw/common/errors.h"

namespace impedraw {

JointDrive::JointDrive(const ModelErrors& errors, double dt)
    : errors_(errors), ripple_phase_(kMaxJoints) {
  const double steps = std::round(errors.loop_delay / dt);
  if (!(steps >= 0.0 && steps <= ModelErrors::kMostDelaySteps))
    throw InputError(
        fmt::format("model errors: loop_delay is {} s, allowed is 0 to {} steps of {} s",
                    errors.loop_delay, ModelErrors::kMostDelaySteps, dt));
  if (!(errors.torque_quantum >= 0.0 && std::isfinite(errors.torque_quantum)))
    throw InputError(fmt::format("model errors: torque_quantum is {}, allowed is 0 or more [Nm]",
                                 errors.torque_quantum));
  if (!std::isfinite(errors.torque_ripple))
    throw InputError(fmt::format("model errors: torque_ripple is {}, allowed is any torque [Nm]",
                                 errors.torque_ripple));
  delay_ = static_cast<int>(steps);
  for (int j = 0; j < kMaxJoints; ++j) ripple_phase_[j] = 2.0 * std::numbers::pi * 0.381966 * j;
}

void JointDrive::reset() noexcept { started_ = false; }

JointVector JointDrive::act(const JointVector& command, const JointVector& q) noexcept {
  JointVector tau = command;
  if (delay_ > 0) {
    if (!started_) std::fill_n(under_way_.begin(), delay_, command);
    started_ = true;
    std::swap(tau, under_way_[static_cast<std::size_t>(oldest_)]);
    oldest_ = (oldest_ + 1) % delay_;
  }
  if (const double quantum = errors_.torque_quantum; quantum > 0.0)
    for (double& value : tau) value = quantum * std::round(value / quantum);
  if (errors_.torque_ripple != 0.0)
    tau.array() += errors_.torque_ripple *
                   (ModelErrors::kRipplePeriods * q + ripple_phase_.head(q.size())).array().sin();
  return tau;
}

}  // namespace impedraw

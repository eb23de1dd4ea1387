#include "impedraw/simulation/joint_drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/simulation/describe_world.h"

namespace impedraw {

JointDrive::JointDrive(const ModelErrors& errors, double dt)
    : errors_(errors), ripple_phase_(kMaxJoints) {
  require_ranges("world.errors", errors);
  const double steps = std::round(errors.loop_delay / dt);
  if (steps > ModelErrors::kMostDelaySteps)
    throw InputError(
        fmt::format("world.errors.loop_delay is {} s, allowed is at most {} steps of {} s",
                    errors.loop_delay, ModelErrors::kMostDelaySteps, dt));
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

// Joint drives: delay, quantisation and ripple of the commanded torque. Formula: ModelErrors.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/control/arm_terms.h"
#include "impedraw/simulation/describe_world.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

class JointDrive {
 public:
  // Throws InputError for a delay, quantum or ripple out of range.
  JointDrive(const ModelErrors& errors, double dt) : errors_(errors), ripple_phase_(kMaxJoints) {
    require_ranges("world.errors", errors);
    const double steps = std::round(errors.loop_delay / dt);
    if (steps > ModelErrors::kMostDelaySteps)
      throw InputError(
          fmt::format("world.errors.loop_delay is {} s, allowed is at most {} steps of {} s",
                      errors.loop_delay, ModelErrors::kMostDelaySteps, dt));
    delay_ = static_cast<int>(steps);
    for (int j = 0; j < kMaxJoints; ++j) ripple_phase_[j] = 2.0 * std::numbers::pi * 0.381966 * j;
  }

  void reset() noexcept { started_ = false; }  // forgets past commands

  // Returns the torque that acts at joint position q, given the newest command.
  JointVector act(const JointVector& command, const JointVector& q) noexcept {
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

 private:
  ModelErrors errors_;
  JointVector ripple_phase_;                                         // of kMaxJoints
  std::array<JointVector, ModelErrors::kMostDelaySteps> under_way_;  // ring of delay_ commands
  int delay_ = 0;                                                    // [steps]
  int oldest_ = 0;
  bool started_ = false;
};

}  // namespace impedraw

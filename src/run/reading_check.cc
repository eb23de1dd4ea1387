#include "impedraw/run/reading_check.h"

#include <cmath>

#include <fmt/format.h>

namespace impedraw {

namespace {

constexpr double kAhead = 0.02, kOldest = 1.0;  // [s]

}  // namespace

ReadingCheck::ReadingCheck(const DriverInfo& driver, const JointVector& speed_limit,
                           const JointVector& torque_limit, double wrench_delay)
    : velocity_(driver.velocity),
      wrench_(driver.wrench != WrenchReading::none),
      wrench_delay_(wrench_delay),
      motion_(speed_limit, torque_limit) {}

bool ReadingCheck::update(const ArmState& state, const JointVector& torque,
                          const JointVector& external) noexcept {
  const std::string found = contradiction(state);
  time_ = state.time;
  if (!state.stalled && state.q.allFinite() && (!velocity_ || state.v.allFinite())) {
    motion_.update(state.q, velocity_ ? &state.v : nullptr, torque, external,
                   state.state_time - state_time_);
    state_time_ = state.state_time;
  }
  if (!cause_.empty()) return false;
  cause_ = found.empty() ? motion_.cause() : found;
  return !cause_.empty();
}

std::string ReadingCheck::contradiction(const ArmState& state) {
  still_ = state.time == time_ ? still_ + 1 : 0;
  if (still_ > kMostStill) return "the arm's clock stands still";
  if (!(state.time >= time_))
    return fmt::format("the arm's clock went back from {:.3f} s to {:.3f} s", time_, state.time);
  const auto outside = [&](const char* what, double stamp, double delay) -> std::string {
    const double ahead = stamp - state.time;
    if (ahead <= kAhead + delay && stamp >= -kOldest) return {};
    return fmt::format("the {} is stamped {:.3f} s {} the arm's clock", what, std::abs(ahead),
                       ahead < 0.0 ? "behind" : "ahead of");
  };
  std::string cause = outside("joint state", state.state_time, 0.0);
  if (cause.empty() && wrench_) cause = outside("wrench", state.wrench_time, wrench_delay_);
  return cause;
}

JointVector ReadingCheck::confirmed(const ArmState& state) const noexcept {
  return velocity_ ? motion_.confirmed(state.v) : JointVector::Zero(state.v.size());
}

}  // namespace impedraw

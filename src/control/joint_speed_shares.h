// The shares of a joint's speed limit at which something reacts, from the plan to the last resort.
// Each layer leaves the one before it room to work.
#pragma once

namespace impedraw {

struct JointSpeedShares {
  // A motion that is damped counts as at rest below the first, and as calm below the second.
  static constexpr double kStill = 0.002, kCalm = 0.05;
  // Torques that stay at their limits while a joint is faster than this feed a swing.
  static constexpr double kSwing = 0.5;
  static constexpr double kPlanned = 0.7;        // default of path.joint_speed_share
  static constexpr double kClockYields = 0.85;   // the plan's clock slows down …
  static constexpr double kLaw = 0.9;            // what the law may ask for
  static constexpr double kClockStands = 1.15;   // … until it stands
  static constexpr double kBrakedLimited = 1.2;  // damped while torques are at their limits
  static constexpr double kBraked = 2.5;         // damped at once; a joint's end stop gives 1.9
};

static_assert(JointSpeedShares::kStill < JointSpeedShares::kCalm);
static_assert(JointSpeedShares::kCalm < JointSpeedShares::kSwing);
static_assert(JointSpeedShares::kSwing < JointSpeedShares::kPlanned);
static_assert(JointSpeedShares::kPlanned < JointSpeedShares::kClockYields);
static_assert(JointSpeedShares::kClockYields < JointSpeedShares::kLaw);
static_assert(JointSpeedShares::kLaw < 1.0 && 1.0 < JointSpeedShares::kClockStands);
static_assert(JointSpeedShares::kClockStands < JointSpeedShares::kBrakedLimited);
static_assert(JointSpeedShares::kBrakedLimited < JointSpeedShares::kBraked);

}  // namespace impedraw

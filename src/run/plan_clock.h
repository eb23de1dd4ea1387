// The plan's clock: runs as planned while the pen follows, and yields where it does not.
//
//   dt_plan/dt = r,  0 ≤ r ≤ 1
//
// The deviations are those of tip, tilt and force from what the plan asks; the tip's speed along
// the estimated normal, as a rough surface lifts and drops it; and the fastest joint's share of its
// speed limit. Each deviation x has two bounds. Up to `slow` the clock runs at 1; from there it
// slows down, and from `stop` on it stands:
//   r → (stop − x)/(stop − slow), the least over all deviations
// r changes at most at the given rates, so that the desired motion keeps a continuous velocity. The
// clock never runs backwards and never jumps. A pen that does not come back within `patience` is
// left behind: the clock then runs at least at `least`, and the gap is drawn again at the end.
//
// The reference at plan time s(t) has velocity r v and acceleration r² a + ṙ v.
#pragma once

#include "impedraw/control/joint_speed_shares.h"
#include "impedraw/control/tip_reference.h"

namespace impedraw {

struct YieldBounds {
  double slow, stop;
};

struct ClockSettings {
  YieldBounds tip{5e-3, 12e-3};  // distance of the tip from the desired point, tangential [m]
  YieldBounds tilt{0.10, 0.30};  // angle between pen and desired axis [rad]
  YieldBounds force{0.7, 1.4};   // deviation of the measured push, as a share of the desired one
  YieldBounds normal_speed{3.5e-3, 9e-3};  // RMS of the tip's speed along the normal [m/s]
  // Fastest joint, as a share of its speed limit.
  YieldBounds joint{JointSpeedShares::kClockYields, JointSpeedShares::kClockStands};
  // A joint counts with the speed that it will have so much later if it goes on like this: near a
  // singular posture it rises steeply [s].
  double foresight = 0.08;
  double force_filter = 0.03;        // time constant of that deviation [s]
  double normal_speed_filter = 0.1;  // and of the mean of squares [s]
  double slow_down = 10.0;           // [1/s]
  double speed_up = 3.0;             // [1/s]
  double patience = 1.0;             // [s]
  double least = 0.2;                // rate after patience is lost
};

// Deviations of the pen from its plan in one cycle. NaN: unknown, does not count.
struct PenDeviation {
  double tip = 0.0;           // [m]
  double tilt = 0.0;          // [rad]
  double force = 0.0;         // share
  double joint = 0.0;         // share
  double limit = 1.0;         // greatest rate that the joints allow (path_follower.h)
  bool waits = false;         // for contact at a stroke's first point
  double normal_speed = 0.0;  // tip speed along the normal [m/s]
  bool paused = false;        // by a user: the clock stands, and no patience is lost
};

class PlanClock {
 public:
  PlanClock(const ClockSettings& settings, double dt) : settings_(settings), dt_(dt) {}

  // One cycle.
  void advance(const PenDeviation& pen) noexcept;

  double lag() const { return lag_; }    // time by which the plan is late [s]
  double rate() const { return rate_; }  // r
  // Time by which the plan goes on while the clock stops [s].
  double way() const { return 0.5 * rate_ * rate_ / settings_.slow_down + dt_; }
  // The plan's reference as it is at the clock's rate.
  TipReference scaled(TipReference reference) const noexcept;

 private:
  ClockSettings settings_;
  double dt_;
  double lag_ = 0.0, rate_ = 1.0, slope_ = 0.0;
  double force_ = 0.0;
  double normal_speed_squared_ = 0.0;
  double joint_ = 0.0, joint_rise_ = 0.0;  // last share, and its filtered rise [1/s]
  double stood_ = 0.0;                     // since the clock ran at `least` or more [s]
};

}  // namespace impedraw

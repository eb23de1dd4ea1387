// Carries out a drawing's moves cycle by cycle, and reacts to what the monitors find meanwhile
// (reaction.h).
#pragma once

#include <algorithm>
#include <functional>
#include <optional>

#include "impedraw/common/minimum_jerk.h"
#include "impedraw/common/pose.h"
#include "impedraw/control/tip_reference.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/run/driven_arm.h"
#include "impedraw/run/driver.h"
#include "impedraw/run/monitors/block_monitor.h"
#include "impedraw/run/monitors/canvas_monitor.h"
#include "impedraw/run/monitors/dead_wrench_monitor.h"
#include "impedraw/run/monitors/fence_monitor.h"
#include "impedraw/run/monitors/range_monitor.h"
#include "impedraw/run/monitors/rattle_monitor.h"
#include "impedraw/run/monitors/reach_monitor.h"
#include "impedraw/run/monitors/reading_monitor.h"
#include "impedraw/run/monitors/reversal_monitor.h"
#include "impedraw/run/monitors/sign_monitor.h"
#include "impedraw/run/monitors/speed_monitor.h"
#include "impedraw/run/monitors/state_monitor.h"
#include "impedraw/run/monitors/step_time_monitor.h"
#include "impedraw/run/monitors/tare_monitor.h"
#include "impedraw/run/path_follower.h"
#include "impedraw/run/reaction.h"
#include "impedraw/run/run.h"

namespace impedraw {

// The monitors of a driven arm, whatever it does.
class ArmMonitors {
 public:
  ArmMonitors(const Experiment& experiment, const Driver& driver, const RunHooks& hooks);

  // The worst verdict on a cycle. `blocked`: the pen is being lifted at a blocked place.
  Verdict judge(const Cycle& cycle, const Reaction& reaction, bool blocked);

  // The joints' speed, as far as the positions confirm it [rad/s].
  JointVector confirmed_speed(const ArmState& state) const { return reading_.confirmed(state); }
  TareMonitor& tare() { return tare_; }

 private:
  Verdict emergency(const Cycle& cycle) const;

  const Driver& driver_;
  const RunHooks& hooks_;
  StateMonitor state_;
  TareMonitor tare_;
  ReadingMonitor reading_;
  ReversalMonitor reversal_;
  SignMonitor signs_;
  DeadWrenchMonitor dead_wrench_;
  FenceMonitor fences_;
  RangeMonitor range_;
  SpeedMonitor speed_;
  RattleMonitor rattle_;
  StepTimeMonitor step_time_;
};

// The end of a run that cannot continue: the pen lifts off along the surface normal and stays up.
class EmergencyLift {
 public:
  static constexpr double kDuration = 1.0;    // at least [s]
  static constexpr double kHeight = 0.03;     // [m]
  static constexpr double kMostSpeed = 0.35;  // [m/s]
  static constexpr double kAside = 0.1;       // [s]

  // Keeps the pen's axis as it is at X_WE. aside_W: how far the pen moves across n_W meanwhile, in
  // the first kAside, while it has hardly risen [m].
  EmergencyLift(double start, const Pose& X_WE, const Eigen::Vector3d& n_W, double height = kHeight,
                const Eigen::Vector3d& aside_W = Eigen::Vector3d::Zero())
      : start_(start),
        height_(height),
        duration_(std::max(kDuration, 1.875 * height / kMostSpeed)),
        p_(X_WE.p),
        n_(n_W),
        aside_(aside_W),
        axis_(-X_WE.R.col(2)) {}

  double duration() const { return duration_; }
  bool done(double t) const { return t >= start_ + duration_; }
  // Way of the tip so far, along the normal [m].
  double risen(const Eigen::Vector3d& p_WE) const { return n_.dot(p_WE - p_); }
  // Minimum-jerk motion from rest to rest.
  TipReference at(double t) const {
    const MinimumJerk jerk =
        MinimumJerk::at(std::clamp((t - start_) / duration_, 0.0, 1.0), duration_);
    const MinimumJerk aside = MinimumJerk::at(std::clamp((t - start_) / kAside, 0.0, 1.0), kAside);
    TipReference reference;
    reference.n_WD = axis_;
    reference.p_WD = p_ + height_ * jerk.share * n_ + aside.share * aside_;
    reference.v_WD = height_ * jerk.rate * n_ + aside.rate * aside_;
    reference.a_WD = height_ * jerk.change * n_ + aside.change * aside_;
    return reference;
  }

 private:
  double start_, height_, duration_;
  Eigen::Vector3d p_, n_, aside_, axis_;
};

class Executor {
 public:
  Executor(const Experiment& experiment, DrivenArm& arm, const RunHooks& hooks);

  Situation situation() const;
  // Until the move is done, or a verdict ends it.
  void carry_out(const Move& move);
  bool goes_on() const { return ending_.end == RunEnd::finished; }

  const Ending& ending() const { return ending_; }
  // Motions that were damped, and why; the drawing went on beyond each.
  const std::vector<std::string>& damped() const { return damped_; }

 private:
  void draw(const Move& move);
  void lift();
  void go_to(const Move& move);
  void feel(double depth);
  // Goes along motion(t) in W while goes_on(). waits_for: what the pen waits for, or null.
  void move_in_world(const std::function<bool()>& goes_on, const char* waits_for,
                     const std::function<TipReference(double)>& motion);
  void rest_while(const std::function<bool()>& goes_on, const char* waits_for);

  // One cycle, and the reaction to what the arm's monitors find. Nothing: the run is over.
  std::optional<Cycle> step(const PathSample& desired);
  Law law(const PathSample& desired) const;
  void settle(const Cycle& cycle, Reaction::State before);
  void react(const Verdict& verdict);
  // The plan's clock, and the reaction to what a path's monitors find. False: the path is over.
  bool follow_up(const Cycle& cycle, const Move& move, PathFollower* path);
  void poll(const Cycle& cycle, const PathFollower& path);

  void begin_lift(Verdict::Rise rise, const Eigen::Vector3d& aside_W = Eigen::Vector3d::Zero());
  // within: leaves the canvas within so long; none: within the lift [s].
  void lift_off_canvas(double height, std::optional<double> within = {});
  bool lifted() const;
  void end_lift();
  double clear_height() const;
  void tell_wait(const char* what, double waited) const;
  bool interrupted() const { return hooks_.interrupted && hooks_.interrupted(); }
  bool paused() const { return !arm_.waits() && hooks_.paused && hooks_.paused(); }

  const Experiment& e_;
  DrivenArm& arm_;
  const RunHooks& hooks_;
  Ending ending_;
  Reaction reaction_;
  ArmMonitors monitors_;
  BlockMonitor block_;
  ReachMonitor reach_;
  CanvasMonitor canvas_;
  SecondChance chance_;
  std::optional<EmergencyLift> lift_;  // while the pen goes up
  TipReference rest_;                  // where the pen is, or goes, between paths: in W
  PathEnd last_;                       // how the last path ended
  bool unseen_ = false;                // a place that the cameras do not resolve was felt
  double rate_ = 1.0;                  // rate of the last path's clock
  std::vector<std::string> damped_;
};

}  // namespace impedraw

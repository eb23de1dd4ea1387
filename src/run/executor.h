// Carries out a drawing's moves cycle by cycle, and reacts to what the monitors find meanwhile
// (reaction.h).
#pragma once

#include <functional>
#include <optional>

#include "impedraw/run/arm_monitors.h"
#include "impedraw/run/driven_arm.h"
#include "impedraw/run/emergency_lift.h"
#include "impedraw/run/monitors/block_monitor.h"
#include "impedraw/run/monitors/canvas_monitor.h"
#include "impedraw/run/monitors/reach_monitor.h"
#include "impedraw/run/path_follower.h"
#include "impedraw/run/reaction.h"
#include "impedraw/run/second_chance.h"

namespace impedraw {

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
  void lift_off_canvas();
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

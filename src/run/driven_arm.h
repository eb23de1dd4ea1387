// An arm under control: a driver, the control loop with what it sees, and the log, cycle by cycle.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "impedraw/control/impedance.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/log/log.h"
#include "impedraw/run/canvas_watch.h"
#include "impedraw/run/control_loop.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/driver.h"
#include "impedraw/run/held_arm.h"
#include "impedraw/run/incident.h"
#include "impedraw/run/motion_check.h"
#include "impedraw/run/real_time.h"
#include "impedraw/run/remaining.h"
#include "impedraw/run/run.h"

namespace impedraw {

// The end of a run whose arm is not believed: −M v/T beyond gravity, as far as positions confirm v,
// until the joints are calm, and for at most kDampTime. Zero beyond gravity follows. Sessions of
// driven arms end likewise (drivers/arm_session.h).
class DampedEnd {
 public:
  // v: confirmed [rad/s].
  bool over(const JointVector& v) const noexcept {
    return time_ >= kDampTime || v.cwiseAbs().maxCoeff() < kDampedSpeed;
  }

  // The torques of a cycle of dt [s] in place of the law's, with the gravity that `out` has from
  // the last cycle. M: inertia at the posture [kg m²]; v: confirmed [rad/s]; most: limits [Nm].
  void damp(const JointMatrix& M, const JointVector& v, const JointVector& most, double dt,
            ImpedanceTorque* out) noexcept {
    const JointVector gravity = out->terms.col(kGravity);
    time_ += dt;
    out->status = {};
    out->mode = ContactMode::free;
    out->push = 0.0;
    out->terms.setZero();
    out->terms.col(kGravity) = gravity;
    out->terms.col(kImpedance) = damping_torque(M, v);
    out->tau = (out->terms.col(kImpedance) + gravity).cwiseMax(-most).cwiseMin(most);
  }

 private:
  double time_ = 0.0;  // [s]
};

// The law that makes the torque of a cycle.
struct Law {
  enum class Kind {
    follow,  // the plan
    brake,   // damp the motion, and move the tip at v_WD (ImpedanceController::brake)
    damp,    // damp the joints' speed v alone (driven_arm.h)
  } kind = Kind::follow;
  Eigen::Vector3d v_WD = Eigen::Vector3d::Zero();  // [m/s]
  JointVector v{};                                 // as far as positions confirm it [rad/s]
};

class DrivenArm {
 public:
  // Starts the driver, and the log. Throws as run() does.
  DrivenArm(const Experiment& experiment, Driver& driver, const std::filesystem::path& log_file,
            const RunHooks& hooks, const Resumption* resumption);
  ~DrivenArm();
  DrivenArm(const DrivenArm&) = delete;
  DrivenArm& operator=(const DrivenArm&) = delete;

  // Runs and logs one control cycle, and reads the next state. time_scale: the plan clock's rate.
  // `desired` must outlive the result.
  Cycle step(const PathSample& desired, const Law& law, double time_scale);
  // Runs `work` between two steps. An arm on a wall clock is held meanwhile.
  template <typename Work>
  auto while_held(const Work& work) {
    if (waits_) return work();
    HeldArm held(driver_, arm_, state_);
    auto result = work();
    state_ = held.release();
    return result;
  }
  // Between two steps, at rest: the arm holds another pen, or one whose length was found.
  void hold_pen(const HeldPen& pen);
  const HeldPen& pen() const { return pen_; }
  // Sends the arm's weight as the last torque.
  void end_at_zero();

  double time() const { return state_->time; }  // by the driver's clock [s]
  bool waits() const { return waits_; }         // in lock-step
  double run_time() const { return first_time_ + time(); }
  const ArmState& state() const { return *state_; }
  const Driver& driver() const { return driver_; }
  ControlLoop& loop() { return loop_; }
  const ControlLoop& loop() const { return loop_; }
  const ImpedanceTorque& out() const { return out_; }
  const DampedEnd& damped_end() const { return damped_end_; }
  const InkWatch& ink() const { return ink_; }
  const CanvasHistory& history() const { return history_; }
  const CanvasBelief* belief() const { return watch_ ? &watch_->belief() : nullptr; }
  Pose X_WE() const { return arm_.tip_pose(state_->q); }
  // The tip in the canvas's frame.
  Pose X_KE() const { return loop_.canvas().pose().inverse() * X_WE(); }

  // No step follows.
  const LoopRecord& finish();
  std::vector<IncidentRow> last_rows() const { return last_.rows(); }
  WallTimes close_log(const WallTimes& wall, const Ending& ending);

 private:
  PenTouch touch(const Cycle& cycle) const;
  void keep(Cycle* cycle);

  const Experiment& e_;
  Driver& driver_;
  mutable ArmModel arm_;  // its workspace
  HeldPen pen_;
  const RunHooks& hooks_;
  bool waits_;                          // the driver, for the next command
  double first_time_;                   // where an earlier run left off [s]
  std::unique_ptr<CanvasWatch> watch_;  // null: one snapshot before the run
  ControlLoop loop_;
  LastSeconds last_;
  RealTime real_time_;  // before the driver starts: its session begins in this thread
  StartedDriver started_;
  const ArmState* state_;  // the driver's last
  std::optional<RunLog> log_;
  LogRow row_;
  ImpedanceTorque out_;
  DampedEnd damped_end_;
  InkWatch ink_;
  CanvasHistory history_;
  double known_for_ = 0.0;  // how long the canvas has been known [s]
  LoopRecord record_;
};

}  // namespace impedraw

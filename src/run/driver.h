// The interface between the control loop and an arm: joint state in, joint torque out, a clock, and
// named faults. The loop (run.h), the log and the redrawing are the same for every driver. The
// simulated arm (simulated_arm.h) is the first driver.
//
// Call order, from one thread at a time:
//
//   start()                    once: the arm is ready, at rest, and holds itself until a command
//   read()                     the state at the beginning of a control cycle
//     command(tau, gravity)    the cycle's torque, held until the next command. Send it at once:
//     read()                   the loop logs between command() and read().
//     command(…) …
//   stop()                     once, after the run ends for any reason, errors included
//
// read() and command() alternate, read() first. They do not allocate, do not throw, and do not take
// locks that another thread may hold for long. While the loop plans, at rest, another thread calls
// them for an arm on a wall clock (held_arm.h).
//
// Clock. A driver in lock-step (simulators) waits for command(), then advances by one period. The
// run does not depend on the loop's speed. A driver on a wall clock waits in read() for the next
// cycle. If the loop missed cycles, `step_time` shows it. Times count from start().
//
// Units and frames: SI; W is the world frame, E the pen tip, S the wrench sensor's frame. n joints,
// in the order of the arm's URDF.
//
// The driver of a real arm must also:
//   - run the arm's protocol in its own thread if it can block;
//   - subtract `gravity` if the arm compensates gravity;
//   - limit torque and torque rate with a margin to the arm's limits;
//   - ramp up the first torques;
//   - take state_time and wrench_time from the arm's time stamps, so that lost packets show as age;
//   - monitor joint speed and the connection, and report failures in fault();
//   - damp the motion in stop(), then send zero torque.
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "impedraw/common/pose.h"
#include "impedraw/control/arm_terms.h"
#include "impedraw/control/moving_frame.h"
#include "impedraw/perception/canvas_frame.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

// The pen that the arm holds.
struct HeldPen {
  int number = -1;      // its place in the scenario's `pens`; -1: that of `pen`
  double longer = 0.0;  // its tip beyond that of arm.urdf, along the pen, as far as is known [m]
  double radius = 0.0;  // of its tip [m]
  // The place of the spot of `pen.check` along its normal, in W; absent: not known yet [m].
  std::optional<double> spot;
};

enum class WrenchReading {
  none,
  sensor,  // [f; m] at S in its axes, tool and bias included, as a sensor between flange and pen
  tip,     // of the environment on the tip: [f; m] at E in W
};

struct DriverInfo {
  int joints = 0;
  double period = 1e-3;  // between two cycles [s]
  WrenchReading wrench = WrenchReading::none;
  bool velocity = true;        // ArmState::v is given; otherwise the loop must estimate it
  bool waits = true;           // in lock-step: time stands still between read() and command()
  bool checks_motion = false;  // by motion_check.h; otherwise the loop does
};

struct ArmState {
  double time = 0.0;  // of this cycle, by the driver's clock [s]
  // When q and v arrived, the sensor's own delay not counted; earlier than `time` if stale [s].
  double state_time = 0.0;
  JointVector q, v;                  // as measured [rad], [rad/s]
  double wrench_time = 0.0;          // when the wrench was measured [s]
  Vector6 wrench = Vector6::Zero();  // as DriverInfo::wrench says [N, Nm]
  // The previous control step is still running in this cycle, and the drives hold the last torque.
  // The loop skips the control law, logs, and commands the same torque again.
  bool stalled = false;
  // The pen's shaft touches the canvas. In a simulator the canvas pushes on the tip alone; an arm
  // would feel this in its wrench.
  bool shaft_touches = false;
  // Duration of the previous control step by the driver's clock [s]; 0 in lock-step.
  double step_time = 0.0;

  explicit ArmState(int joints) : q(JointVector::Zero(joints)), v(q) {}
};

// Data known only to a simulator. For the log; the controller never sees it.
struct GroundTruth {
  static Eigen::Vector3d no_vector() {
    return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  }

  // At the time of the last read().
  JointVector q, v;
  Pose X_WE;
  Vector6 V_WE = Vector6::Zero();
  Pose X_WK;  // of the canvas
  // Over the cycle that the last command() began.
  Eigen::Vector3d contact_force = Eigen::Vector3d::Zero();  // of the canvas on the tip, W [N]
  // The point of the canvas closest to the tip and the outward normal there, in the canvas's frame
  // K, which is W until the canvas moves; NaN out of contact.
  Eigen::Vector3d contact_point = no_vector(), contact_normal = no_vector();
  Eigen::Vector3d disturbance_force = Eigen::Vector3d::Zero();  // a push on the pen, W [N]
  // Since start().
  SolverCutoffs cutoffs;
};

class Driver {
 public:
  virtual ~Driver() = default;

  virtual DriverInfo info() const = 0;

  // Throws std::runtime_error that names the problem: no connection, wrong arm.
  virtual void start() = 0;

  // The result belongs to the driver and is overwritten by the next read().
  virtual const ArmState& read() noexcept = 0;

  // tau: joint torque, including gravity compensation [Nm]; gravity: the part of tau that
  // compensates the arm's weight [Nm].
  virtual void command(const JointVector& tau, const JointVector& gravity) noexcept = 0;

  // The reason that the arm can no longer be driven, as a user message; empty while it can. Stays
  // set until start(). Checked after every read().
  virtual const std::string& fault() const noexcept = 0;

  // Leaves the arm in a safe state. May be called in any state and repeatedly.
  virtual void stop() noexcept = 0;

  // After a fault and stop(): clears the fault where the arm allows it and it is of a kind after
  // which a program may go on. True: start() may be called again, and the arm rests at *q.
  virtual bool recover(JointVector*) noexcept { return false; }

  // The next frame of a canvas that moves, of those that have arrived; false: there is none. Called
  // until then: in lock-step once per cycle after read(); on a wall clock by a thread of its own,
  // from start() to stop(), and it must not wait long. What *frame refers to stays until the next
  // call.
  virtual bool next_frame(CanvasFrame*) noexcept { return false; }

  virtual const GroundTruth* truth() const noexcept { return nullptr; }

  // A person has put in the pen of that number: a simulator's own changes with it.
  virtual void put_in(int /*number*/) noexcept {}

  // The true motion of a canvas that moves, at a time of this clock [s], to judge the controller
  // without a tracker (perception.canvas_pose). False: the canvas stands, or its motion is unknown.
  virtual bool true_canvas(double /*time*/, FrameMotion* /*motion*/) const noexcept {
    return false;
  }
};

// Starts a driver and stops it on destruction.
class StartedDriver {
 public:
  explicit StartedDriver(Driver& driver) : driver_(driver) { driver_.start(); }
  ~StartedDriver() { driver_.stop(); }
  StartedDriver(const StartedDriver&) = delete;
  StartedDriver& operator=(const StartedDriver&) = delete;

 private:
  Driver& driver_;
};

}  // namespace impedraw

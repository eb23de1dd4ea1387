// The seam between the control loop and an arm: joint state in, joint torque out, a clock, faults
// by name. The loop (run.h), the log and the redrawing are the same for every driver; the simulated
// arm (simulated_arm.h) is the first.
//
// Law of calls, all from the loop's one thread:
//
//   start()                    once: the arm is ready, at rest, and holds itself until a command
//   read()                     the state at the beginning of a control cycle
//     command(tau, gravity)    its torque, which holds until the next command; sent as soon as it
//     read()                   is known: the loop logs between command() and read()
//     command(…) …
//   stop()                     once, after whatever ended the run, errors included
//
// read() and command() take turns, read() first. They allocate nothing, take no lock that another
// thread may hold for long, and throw nothing. Between the first pass and the redrawing of gaps the
// loop plans, and commands nothing for that long: a driver on a wall clock holds the posture then.
//
// Clock. A driver in lock-step (simulators) stands still until command() and is then a period
// further on: however slow the loop is, the run is the same. A driver on a wall clock waits in
// read() for the next cycle; where the loop came too late for some of them, `step_time` says so.
// Times count from start().
//
// Units and frames: SI; W is the world frame, E the pen tip, S the wrench sensor's frame. n joints,
// in the order of the arm's URDF.
//
// What the driver of a real arm must do beyond that: speak the arm's protocol from a thread of its
// own where that can block; take `gravity` off where the arm compensates its own; keep the arm's
// limits on torque and its rate with a margin, ramp the first torques up; fill state_time and
// wrench_time from the arm's own stamps, so that lost packets show as age; watch joint speed and
// the connection, and name what went wrong in fault(); damp the motion, then send zero, in stop().
#pragma once

#include <limits>
#include <string>

#include "impedraw/common/pose.h"
#include "impedraw/control/arm_terms.h"

namespace impedraw {

enum class WrenchReading {
  none,
  sensor,  // [f; m] at S in its axes, tool and bias included, as a sensor between flange and pen
  tip,     // of the environment on the tip: [f; m] at E in W
};

struct DriverInfo {
  int joints = 0;
  double period = 1e-3;  // between two cycles [s]
  WrenchReading wrench = WrenchReading::none;
};

struct ArmState {
  double time = 0.0;         // of this cycle, by the driver's clock [s]
  double state_time = 0.0;   // when q and v were measured; earlier where there is nothing newer [s]
  JointVector q, v;          // [rad], [rad/s]
  double wrench_time = 0.0;  // when the wrench was measured [s]
  Vector6 wrench = Vector6::Zero();  // as DriverInfo::wrench says [N, Nm]
  // The control step before is not done yet in this cycle: the drives hold the last torque. The
  // loop works out nothing, logs, and commands that torque again.
  bool stalled = false;
  // How long the control step before took by the driver's clock [s]; 0 in lock-step.
  double step_time = 0.0;

  explicit ArmState(int joints) : q(JointVector::Zero(joints)), v(q) {}
};

// What only a simulator knows. For the log; the controller never sees it.
struct GroundTruth {
  static Eigen::Vector3d no_vector() {
    return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  }

  // At the time of the last read().
  JointVector q, v;
  Pose X_WE;
  Vector6 V_WE = Vector6::Zero();
  // Over the cycle that the last command() began.
  Eigen::Vector3d contact_force = Eigen::Vector3d::Zero();  // of the canvas on the tip, W [N]
  // On the canvas, closest to the tip, and its outward normal there, W; NaN out of contact.
  Eigen::Vector3d contact_point = no_vector(), contact_normal = no_vector();
  Eigen::Vector3d disturbance_force = Eigen::Vector3d::Zero();  // a push on the pen, W [N]
};

class Driver {
 public:
  virtual ~Driver() = default;

  virtual DriverInfo info() const = 0;

  // Throws std::runtime_error that names what is missing: no connection, another arm.
  virtual void start() = 0;

  // The answer is the driver's own, overwritten by the next read().
  virtual const ArmState& read() noexcept = 0;

  // tau: joint torque, gravity included [Nm]; gravity: how much of it holds the arm against its
  // weight.
  virtual void command(const JointVector& tau, const JointVector& gravity) noexcept = 0;

  // Why the arm can no longer be driven, in words for a user; empty while it can. Once set it stays
  // until start(). Looked at after every read().
  virtual const std::string& fault() const noexcept = 0;

  // Leaves the arm safe. May be called in any state, more than once.
  virtual void stop() noexcept = 0;

  virtual const GroundTruth* truth() const noexcept { return nullptr; }
};

// Started, and stopped whatever happens.
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

// One cycle of the control loop: what was read, what was commanded, and what is known of it. Every
// monitor and the log read this value. It refers to the loop's own data, until the next cycle.
#pragma once

#include "impedraw/control/impedance.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/run/canvas_follower.h"
#include "impedraw/run/driver.h"

namespace impedraw {

struct Cycle {
  double time = 0.0;       // by the driver's clock, when the cycle began [s]
  double run_time = 0.0;   // the same, from the beginning of the first run [s]
  double dt = 0.0;         // [s]
  double step_time = 0.0;  // duration of the control step before [s]
  double state_age = 0.0;  // [s]
  const PathSample& desired;
  const ArmTerms& arm;
  const OperationalSpace* space = nullptr;  // of the law, from its step on; null: it had none
  const Wrench& F_ext;
  const SurfaceEstimate& surface;
  const CanvasFollower& canvas;
  const ImpedanceTorque& out;
  // The driver's last reading: the cycle's own until its torque is commanded, then the next.
  const ArmState* state;
  const GroundTruth* truth;  // null: none
  bool tared = false;        // the wrench sensor's bias is known, or there is no sensor
  bool inked = false;        // the pen writes, and where it should
  double confirmed = 0.0;    // share of the felt motion along n that frames confirm (felt_motion.h)
  const char* tool = "pen";  // what the arm holds, for people

  // When the state after it was read, from the beginning of the first run [s].
  double next_run_time() const noexcept { return run_time - time + state->time; }
  // Measured force on the tip along the normal [N].
  double normal_force() const noexcept { return F_ext.head<3>().dot(out.n_WD); }
  // From the tip to the point that the law drives it to, in W [m].
  Eigen::Vector3d lag() const noexcept { return out.p_WD - arm.X_WE.p; }
  // The same across the surface [m].
  Eigen::Vector3d behind() const noexcept {
    const Eigen::Vector3d off = lag();
    return off - out.n_WD * out.n_WD.dot(off);
  }
  // Speed of the fastest joint, as a share of its limit [rad/s].
  double speed_share(const JointVector& limit) const noexcept {
    return (arm.v.cwiseAbs().array() / limit.array()).maxCoeff();
  }
  // Tip velocity, relative to a canvas that the pen moves with, in W [m/s].
  Eigen::Vector3d velocity_on_canvas() const noexcept {
    const Eigen::Vector3d v = arm.V_WE.head<3>();
    const FrameMotion* const carrier = canvas.carrier();
    return carrier ? Eigen::Vector3d(v - carrier->velocity_at(arm.X_WE.p)) : v;
  }
};

}  // namespace impedraw

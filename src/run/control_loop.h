// The controller with its inputs: from a driver's state to a torque.
#pragma once

#include <functional>
#include <limits>
#include <optional>

#include "impedraw/arm/arm_model.h"
#include "impedraw/control/depth_hold.h"
#include "impedraw/control/hit_retreat.h"
#include "impedraw/control/impedance.h"
#include "impedraw/experiment/control_setup.h"
#include "impedraw/run/canvas_follower.h"
#include "impedraw/run/driver.h"
#include "impedraw/run/felt_height.h"
#include "impedraw/run/keep_away.h"
#include "impedraw/run/soft_corrections.h"
#include "impedraw/sensing/joint_state_estimator.h"
#include "impedraw/sensing/touch_surface.h"
#include "impedraw/sensing/wrench_estimator.h"

namespace impedraw {

// The perceived surface near a point of the canvas's frame K, in its axes; at a time [s] of the
// driver's clock. K is W for a canvas that stands. Called once per control step; must not allocate.
using SurfaceSource = std::function<SurfaceEstimate(const Eigen::Vector3d& p_K, double time)>;

class ControlLoop {
 public:
  // `surface` empty: the surface is learned from touch if the set-up says so, else unknown.
  // `canvas` empty: it stands. Throws InputError if the driver's joints, period or wrench do not
  // match the set-up.
  ControlLoop(const ControlSetup& setup, const ArmModel& arm, const DriverInfo& driver,
              SurfaceSource surface, CanvasSource canvas = {});

  // One control step. `reference`: in K once canvas().joined(), else in W. The result refers to the
  // controller's own output.
  const ImpedanceTorque& step(const ArmState& state, const TipReference& reference) noexcept;

  // A step that damps the motion instead of following the plan, or moves the tip at v_WD
  // (ImpedanceController::brake).
  const ImpedanceTorque& brake(const ArmState& state, const Eigen::Vector3d& v_WD) noexcept;

  // Values of the last step.
  const ArmTerms& terms() const { return terms_; }
  const OperationalSpace* space() const { return controller_.space(); }
  const Wrench& F_ext() const { return F_ext_; }
  const SurfaceEstimate& surface() const { return surface_; }
  const CanvasFollower& canvas() const { return canvas_; }
  // The pen moves with the canvas from the next step on, and goes over to it within `duration` [s];
  // `reference`: of the last step.
  void join_canvas(const TipReference& reference,
                   double duration = CanvasFollower::kJoin) noexcept {
    TipReference from = reference;
    from.p_WD += keep_away_.shift();
    canvas_.join(from, duration);
  }
  // References are in W again, and the pen goes over to them within `duration` [s].
  void leave_canvas(double duration, const Eigen::Vector3d& up_W) noexcept {
    canvas_.leave(duration, up_W);
  }
  // True while a lifted pen is away from its plan, because of what hit it.
  bool retreats() const noexcept { return !hit_.shift().isZero(0.0); }
  // The tip as measured, in K.
  Pose X_KE() const noexcept { return canvas_.pose().inverse() * terms_.X_WE; }
  // The surface as it is learned from touch; null if it is not.
  const TouchSurface* touch() const { return touch_ ? &*touch_ : nullptr; }
  // Null if the joints' velocities are measured.
  const JointStateEstimator* joint_estimator() const {
    return joint_estimator_ ? &*joint_estimator_ : nullptr;
  }
  // From the next step on the tip is so much farther along its z [m], and of that radius [m]. A
  // pen that is `new_one` weighs something else: the sensor is tared again, at the next rest.
  void change_pen(double longer_by, double radius, bool new_one) {
    arm_.lengthen_pen(longer_by);
    controller_.set_tip_radius(radius);
    if (!estimator_) return;
    estimator_->lengthen_pen(longer_by);
    if (new_one) estimator_->start_tare();
  }
  // A cutter scored the surface here, in an earlier run (depth_hold.h).
  void scored(const Eigen::Vector3d& p_KE, const Eigen::Vector3d& n_K, double f_n) noexcept {
    if (depth_) depth_->touch(p_KE, n_K, f_n);
  }
  // True once the sensor's bias is known, or if there is no sensor.
  bool tared() const noexcept { return !estimator_ || estimator_->tared(); }

 private:
  void update_arm(const ArmState& state) noexcept;
  void update_wrench(const ArmState& state) noexcept;
  // In the last step.
  bool on_surface() const noexcept {
    return mode_ == ContactMode::approach || mode_ == ContactMode::contact;
  }
  TipReference on_canvas(const TipReference& given) noexcept;
  void avoid_canvas(const TipReference& given, double time) noexcept;
  void keep_away(double time) noexcept;

  ArmModel arm_;
  SurfaceSource surface_source_;
  CanvasFollower canvas_;
  ImpedanceController controller_;
  std::optional<JointStateEstimator> joint_estimator_;
  double period_;
  double time_ = std::numeric_limits<double>::quiet_NaN();        // of the last step [s]
  double state_time_ = std::numeric_limits<double>::quiet_NaN();  // of the last joint reading [s]
  std::optional<WrenchEstimator> estimator_;
  std::optional<TouchSurface> touch_;
  std::optional<DepthHold> depth_;
  bool coupled_;  // M_d couples translation and rotation
  ArmTerms terms_;
  SurfaceEstimate surface_;
  Wrench F_ext_ = Wrench::Zero();
  double wrench_time_ = std::numeric_limits<double>::quiet_NaN();  // of F_ext_ [s]
  Eigen::Vector3d n_ = Eigen::Vector3d::UnitZ();                   // of the last step
  ContactMode mode_ = ContactMode::free;                           // of the last step
  FeltHeight felt_height_;
  HitRetreat hit_;
  KeepAway keep_away_;
  SoftCorrections soft_;
};

}  // namespace impedraw

// Fences: a box, a force, a moment, a speed and a lag of the tip that end a run.
//
// Speed, force and moment must be beyond for kConfirm: a single outlier is ignored. The
// lag, |p_WD − p_WE| of the point that the law drives the tip to, must be for kConfirmLag: motion
// must follow torque, and an arm that stands still does not. A measured wrench has fences by
// default: what is larger is no contact of a pen. What is not finite is not judged here: the
// control law says bad_input.
#pragma once

#include <string>

#include <Eigen/Core>

#include "impedraw/experiment/scenario.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

class FenceMonitor {
 public:
  static constexpr double kConfirm = 3e-3, kConfirmLag = 0.1;  // [s]
  static constexpr double kForce = 150.0, kMoment = 30.0;      // by default [N], [Nm]

  // `measured`: the wrench on the tip is. Throws InputError if the box is empty, or a force or a
  // moment is given and not measured.
  FenceMonitor(const FenceSettings& settings, bool measured);

  // p_WE [m], v_WE [m/s], f: force on the tip, W [N], m: moment at it [Nm], lag [m]. True in the
  // cycle in which a fence is first crossed.
  bool update(const Eigen::Vector3d& p_WE, const Eigen::Vector3d& v_WE, const Eigen::Vector3d& f,
              double dt, const Eigen::Vector3d& m = Eigen::Vector3d::Zero(),
              double lag = 0.0) noexcept;

  // The same, after a cycle.
  Verdict judge(const Cycle& cycle);

  // The force is beyond its fence, confirmed or not: until it is, no other monitor names a cause.
  bool force_beyond() const { return force_above_ > 0.0; }

  // The fence that was crossed, with its value and the measured one; empty: none.
  std::string crossed() const;

 private:
  enum class Kind { none, box, force, moment, speed, lag };

  FenceSettings settings_;
  Kind kind_ = Kind::none;
  int axis_ = 0;
  double value_ = 0.0;
  double force_above_ = 0.0, moment_above_ = 0.0, speed_above_ = 0.0, lag_above_ = 0.0;  // [s]
};

}  // namespace impedraw

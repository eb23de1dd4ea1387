// The surface under the pen, learned from touch alone: no camera, no model. From the measured
// force on the tip and from where the tip has been, a height field around the tip:
//   h(x + d) = h + g·d + ½ dᵀ H d          along the drawing axis z; x, d in the drawing plane
//   n        = (−g, 1)/|(−g, 1)|
//
// State     h, slope g (2), curvature H (3), and their covariance: a Kalman filter in the length
//           of the path. Its transition from one place to the next is the law above, exactly.
// Height    The centre of the tip sphere moves on the surface's parallel at the tip's radius, which
//           has the same normals. The tip's compression f_n/k is taken out. The track of touched
//           points thus gives the slope along the path: n · dp = 0.
// Force     F = f_n (n − μ t), t = the unit vector of the slip. Across the slip friction has no
//           part: with u in the drawing plane and normal to the slip, F·u = f_n n·u and
//           (F − t (t·F))·z = f_n n·z, so that g·u = −F·u/(F − t (t·F))·z, whatever μ is.
// Standing  friction may hide a slope of up to μ in any direction. Once the force has settled after
//           a touch, g = −F_xy/F_z ± μ/√3 is used.
// Noise     H changes at random, with the standard deviation κ (`curvature`) and the correlation
//           length ℓ (`curvature_length`). At a corner all that was learned remains known.
// Before    a touch the surface is the level plane through the tip where the pen was first wanted
//           down. An approach that may go beneath it finds the surface.
// After     contact is lost the height field is carried on. Deeper than `search` beneath it, the
//           status is off_edge: the surface has ended.
// Turning   The reported normal follows the learned one at `turn_rate` at most, and takes up speed
//           and slows down within 0.1 s: the pen has to follow it.
// Errors    On a sphere or a cylinder, whose H is nearly constant, n has no lag. Steps and edges
//           are learned within millimetres. At the touch itself the error is up to atan μ.
// Source    n · v = 0 and the force less friction: e.g. T. Yoshikawa, A. Sudou, "Dynamic hybrid
//           position/force control of robot manipulators: on-line estimation of unknown
//           constraint", IEEE Trans. Robotics and Automation 9(2), 1993.
#pragma once

#include "impedraw/common/pose.h"
#include "impedraw/control/surface_estimate.h"
#include "impedraw/sensing/touch_settings.h"

namespace impedraw {

class TouchSurface {
 public:
  // Throws InputError naming the setting, its value and what is valid.
  TouchSurface(const TouchSettings& settings, const TouchModel& model);

  // One step: the tip's pose and velocity [v; ω], the force of the environment on it [N], in W, and
  // whether the plan wants the pen down. Allocates nothing. A force that is not finite is ignored.
  const SurfaceEstimate& update(const Pose& X_WE, const Vector6& V_WE, const Eigen::Vector3d& f_W,
                                bool pen_down) noexcept;

  const SurfaceEstimate& estimate() const { return estimate_; }
  // The same at a point next to the tip, as surface_query() gives it, by the learned curvature.
  SurfaceEstimate estimate_at(const Eigen::Vector3d& p_W) const noexcept;
  // The surface has been touched since the pen was wanted down.
  bool touched() const { return touched_; }
  bool touching() const { return touching_; }
  // Slope and curvature of the height field, in the drawing plane's axes that axes() gives.
  Eigen::Vector2d slope() const { return x_.segment<2>(1); }
  Eigen::Matrix2d curvature() const;
  // Columns: x and y of the drawing plane, and z.
  const Eigen::Matrix3d& axes() const { return R_; }

 private:
  using Covariance = Matrix6;

  void begin(const Eigen::Vector3d& c) noexcept;
  void move_to(const Eigen::Vector3d& c) noexcept;
  void correct(const Vector6& row, double innovation, double variance) noexcept;
  void learn(const Eigen::Vector3d& c, const Eigen::Vector3d& v, const Eigen::Vector3d& f) noexcept;
  void turn_to(const Eigen::Vector3d& n_W) noexcept;
  Eigen::Vector3d normal(const Eigen::Vector2d& slope) const noexcept;
  double height_at(const Eigen::Vector3d& c) const noexcept;

  TouchSettings s_;
  TouchModel m_;
  Eigen::Matrix3d R_;
  Vector6 x_ = Vector6::Zero();  // h, g_x, g_y, H_xx, H_xy, H_yy at `at_`
  Covariance P_ = Covariance::Zero();
  Eigen::Vector2d at_ = Eigen::Vector2d::Zero();
  bool down_ = false, touched_ = false, touching_ = false, stood_ = false;
  double since_touch_ = 0.0;                      // [s]
  Eigen::Vector3d n_ = Eigen::Vector3d::UnitZ();  // reported, W
  double turning_ = 0.0;                          // its angular speed [rad/s]
  Eigen::Vector3d p_WE_ = Eigen::Vector3d::Zero();
  SurfaceEstimate estimate_;
};

}  // namespace impedraw

// The surface under the pen, learned from touch alone: no camera, no model. From the measured force
// on the tip and from where the tip has been, a height field around the tip:
//   h(x + d) = h + g·d + ½ dᵀ H d          along the drawing axis z; x, d in the drawing plane
//   n        = (−g, 1)/|(−g, 1)|
//
// State     h, slope g (2), curvature H (3), with their covariance: a Kalman filter in the length of
//           the path. Its transition from one place to the next is the law above, exactly.
// Height    The centre of the tip sphere moves on the surface's parallel at the tip's radius, which
//           has the same normals. The tip's compression f_n/k is taken out. Along the path, the
//           track of touched points thus gives the slope: n · dp = 0.
// Force     F = f_n (n − μ t), t = the unit vector of the slip. Across the slip friction has no
//           part: with u in the drawing plane and normal to the slip, F·u = f_n n·u and
//           (F − t (t·F))·z = f_n n·z, so that g·u = −F·u/(F − t (t·F))·z, whatever μ is.
// Standing  friction may hide a slope of up to μ in any direction. When the force has settled after
//           a touch, g = −F_xy/F_z ± μ/√3 is used once.
// Noise     H changes at random with the correlation length ℓ and the standard deviation κ
//           (`curvature_length`, `curvature`). A slope that the path does not cross is known as well
//           as the force tells it. At a corner all remains known.
// Before    a touch the surface is taken to be the level plane through the tip where the pen was
//           first wanted down, so that an approach that may go beneath it finds the surface.
// After     contact is lost the height field is carried on. Deeper than `search` beneath it, the
//           status is off_edge: the surface has ended.
// Errors    On a sphere or a cylinder, whose H is nearly constant, n has no lag. Steps and edges
//           are learned within millimetres. At the touch itself the error is up to atan μ.
// Source    The geometry of n · v = 0 and of F less friction: e.g. T. Yoshikawa, A. Sudou, "Dynamic
//           hybrid position/force control of robot manipulators: on-line estimation of unknown
//           constraint", IEEE Trans. Robotics and Automation 9(2), 1993.
#pragma once

#include "impedraw/common/pose.h"
#include "impedraw/common/range.h"
#include "impedraw/control/surface_estimate.h"

namespace impedraw {

struct TouchSettings {
  double slope = 0.6;               // standard deviation of g before the first touch
  double curvature = 10.0;          // κ: of H [1/m]
  double curvature_length = 0.03;   // ℓ: over which H changes [m]
  double position_noise = 20e-6;    // of a touched height [m]
  double force_noise = 0.05;        // of the slope that a force tells, over `spacing`
  double spacing = 50e-6;           // of the touched points along the path [m]
  double slip_speed = 5e-3;         // slower, the direction of friction is not known [m/s]
  double turn_rate = 2.0;           // greatest of the reported normal [rad/s]
  double search = 5e-3;             // beneath a surface that has been touched [m]
  double settle_time = 0.1;         // from a touch to the use of the standing force [s]

  struct Limits {
    static constexpr Limit slope = {"slope", "", {0.01, 10.0}};
    static constexpr Limit curvature = {"curvature", "1/m", {0.0, 1000.0}};
    static constexpr Limit curvature_length = {"curvature_length", "m", {1e-3, 10.0}};
    static constexpr Limit position_noise = {"position_noise", "m", {1e-7, 1e-2}};
    static constexpr Limit force_noise = {"force_noise", "", {1e-4, 10.0}};
    static constexpr Limit spacing = {"spacing", "m", {1e-6, 1e-2}};
    static constexpr Limit slip_speed = {"slip_speed", "m/s", {1e-4, 1.0}};
    static constexpr Limit turn_rate = {"turn_rate", "rad/s", {0.01, 100.0}};
    static constexpr Limit search = {"search", "m", {1e-4, 0.1}};
    static constexpr Limit settle_time = {"settle_time", "s", {0.0, 10.0}};
  };
};

// What the controller believes of pen and step.
struct TouchModel {
  double dt = 1e-3;                                           // [s]
  Eigen::Vector3d drawing_axis_W = Eigen::Vector3d::UnitZ();  // z, unit
  double tip_radius = 1e-3;                                   // [m]
  double tip_stiffness = 20e3;                                // along the normal [N/m]; 0: rigid
  double friction = 0.3;                                      // μ, while the pen stands
  double touch_force = 0.3;                                   // [N]
};

class TouchSurface {
 public:
  // Throws InputError naming the setting, its value and what is valid.
  TouchSurface(const TouchSettings& settings, const TouchModel& model);

  // One step: the tip's pose and velocity [v; ω], the force of the environment on it [N], in W, and
  // whether the plan wants the pen down. Allocates nothing. A force that is not finite is ignored.
  const SurfaceEstimate& update(const Pose& X_WE, const Vector6& V_WE, const Eigen::Vector3d& f_W,
                                bool pen_down) noexcept;

  const SurfaceEstimate& estimate() const { return estimate_; }
  // The surface has been touched since the pen was wanted down.
  bool touched() const { return touched_; }
  bool touching() const { return touching_; }
  // Slope and curvature of the height field, in the drawing plane's axes that axes() gives.
  Eigen::Vector2d slope() const { return x_.segment<2>(1); }
  Eigen::Matrix2d curvature() const;
  // Standard deviation of the normal, in its worst direction [rad].
  double uncertainty() const noexcept;
  // Columns: x and y of the drawing plane, and z.
  const Eigen::Matrix3d& axes() const { return R_; }

 private:
  using Covariance = Matrix6;

  void begin(const Eigen::Vector3d& c) noexcept;
  void move_to(const Eigen::Vector3d& c) noexcept;
  void correct(const Vector6& row, double innovation, double variance) noexcept;
  void learn(const Eigen::Vector3d& c, const Eigen::Vector3d& v, const Eigen::Vector3d& f) noexcept;
  Eigen::Vector3d normal(const Eigen::Vector2d& slope) const noexcept;
  double height_at(const Eigen::Vector3d& c) const noexcept;

  TouchSettings s_;
  TouchModel m_;
  Eigen::Matrix3d R_;
  Vector6 x_ = Vector6::Zero();  // h, g_x, g_y, H_xx, H_xy, H_yy at `at_`
  Covariance P_ = Covariance::Zero();
  Eigen::Vector2d at_ = Eigen::Vector2d::Zero();
  bool down_ = false, touched_ = false, touching_ = false, stood_ = false;
  double since_touch_ = 0.0;  // [s]
  Eigen::Vector3d n_ = Eigen::Vector3d::UnitZ();  // reported, W
  SurfaceEstimate estimate_;
};

}  // namespace impedraw

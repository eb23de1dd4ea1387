// The rates of the arm's joints along a stroke, as a limit on the speed of the plan.
//
// Along a spline with coordinate u the postures q(u) follow each other by the motion of least
// kinetic energy, as under the controller. A joint's speed is |dq_j/du| u̇, so that
//   u̇ ≤ share · v_max,j / |dq_j/du|  for each joint j
// Its acceleration is d²q_j/du² u̇² + dq_j/du ü, so that
//   u̇² ≤ 0.8 a_max / |d²q_j/du²|,  ü ≤ (a_max − |d²q_j/du²| u̇²) / |dq_j/du|
// and its torque is g + Jᵀ F + (M d²q/du² + C(q, dq/du) dq/du) u̇² + M dq/du ü, so that with what
// holding the arm and pressing the pen on leave of the limit, r_j = share · τ_max,j − |g + Jᵀ F|_j,
//   u̇² ≤ 0.8 r_j / |M d²q/du² + C dq/du|_j,  ü ≤ (r_j − |M d²q/du² + C dq/du|_j u̇²) / |M dq/du|_j
// Slopes and bends are differences over steps of kStep, and near singular postures of finer ones.
// Within less than that, acceleration passes its limit by up to a quarter. Where no posture is
// found, or holding the arm takes all of the torque, the limits stay as they are: the pre-flight
// reports such places.
#pragma once

#include "impedraw/arm/arm_model.h"
#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/planning/path/tip_planner.h"

namespace impedraw {

// The load of the arm while it draws.
struct DrawingLoad {
  double normal_force = 0.0;  // F [N]
  double friction = 0.0;      // μ
  double torque_share = 1.0;  // the controller's, of the arm's torque limits
};

class JointRates {
 public:
  static constexpr double kStep = 1e-3;  // between postures [m]

  // rest_q: the null space's.
  JointRates(const ArmModel& arm, const PathSettings& settings, const JointVector& start_q,
             const JointVector& rest_q, const DrawingLoad& load = {});

  void operator()(const PathSpline& spline, std::vector<SpeedSpan>* spans);

 private:
  bool follow(const SplinePoint& at, double moved);
  PenPlacement placement(const SplinePoint& at) const;

  ArmModel arm_;
  Pose X_WP_;
  bool vertical_pen_;
  std::optional<double> yaw_;  // of a led tool [rad]
  JointVector limit_;          // share · v_max [rad/s]
  double acceleration_;        // a_max [rad/s²]
  JointVector torque_;         // share · τ_max [Nm]
  DrawingLoad load_;
  JointVector rest_, q_;
  ArmTerms terms_;
};

}  // namespace impedraw

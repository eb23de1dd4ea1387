// Settings of the pre-flight, from a scenario and from what the cameras saw (plan.h).
#include "impedraw/experiment/plan.h"

namespace impedraw {

PreflightSettings preflight_settings(const Scenario& scenario, const Pose& X_WP, bool seen,
                                     const JointVector& rest_q) {
  PreflightSettings s = scenario.preflight;
  s.X_WP = X_WP;
  s.vertical_pen = !seen;
  s.normal_force = scenario.control.normal_force;
  s.torque_share = scenario.control.torque_share;
  s.friction = scenario.control.friction.coefficient;
  s.normal_smoothing = scenario.path.normal_smoothing, s.lean_deg = scenario.path.lean_deg;
  s.space = scenario.control.operational_space;
  // The foam of a pad gives way.
  if (scenario.tool.kind == ToolKind::pad) s.tip_length = PadSettings().thickness;
  s.rest_q = rest_q;
  s.speed = scenario.path.draw_speed;
  return s;
}

std::function<double(const Eigen::Vector3d&)> height_error(const Belief& belief) {
  if (!belief.perception) return {};
  // The misfit is an RMS.
  return [seen = belief.perception](const Eigen::Vector3d& p_W) {
    return 2.0 * seen->roughness(p_W).misfit;
  };
}

}  // namespace impedraw

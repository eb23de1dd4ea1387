#include "impedraw/run/log_row.h"

#include <algorithm>
#include <string>

#include "impedraw/common/rotations.h"
#include "impedraw/run/run_folder.h"

namespace impedraw {

RunLogHeader make_header(const Experiment& e) {
  RunLogHeader h;
  h.joint_names = e.belief.arm.joint_names();
  h.joint_lower = e.belief.arm.limits().lower;
  h.joint_upper = e.belief.arm.limits().upper;
  h.torque_limit = e.belief.arm.limits().torque;
  h.joint_speed_limit = e.belief.arm.limits().speed;
  h.moving_canvas = e.yardstick.canvas_moves || e.scenario.perception.frames.enabled;
  h.joint_sensor = !e.scenario.world.joint_sensor.exact();
  for (const std::string_view name : kTorqueTermNames) h.torque_terms.emplace_back(name);
  for (const std::string_view name : kContactModeNames) h.mode_names.emplace_back(name);
  h.canvas_vertices = e.yardstick.canvas.vertices;
  h.canvas_triangles = e.yardstick.canvas.triangles;
  if (e.belief.perception) {
    h.cloud_points = e.belief.perception->cloud().points;
    h.cloud_normals = e.belief.perception->cloud().normals;
    h.cloud_camera = e.belief.perception->cloud().camera;
    h.cloud_colour = packed_colours(e.belief.perception->cloud());
  }
  h.target_points = e.yardstick.target.points;
  h.target_stroke = e.yardstick.target.stroke;
  h.rate = e.scenario.log.rate;
  h.dt = e.scenario.world.dt;
  h.attributes = record_of(e.scenario, e.inputs);
  h.attributes["scenario"] = e.scenario.name;
  if (e.scenario.arm.driver != ArmDriver::sim)
    h.attributes["contact"] = e.control.impedance.wrench == WrenchFeedback::measured
                                  ? "estimated: the measured wrench at the model's tip"
                                  : "unknown: no simulator of ours, and no wrench";
  if (is_rehearsal(e.scenario))
    h.attributes["rehearsal"] = "the canvas is the surface that was seen, not the real one";
  h.attributes["seed"] = std::to_string(e.scenario.seed);
  h.attributes[kPromiseAttribute] = promise_text(e.yardstick.promise);
  h.line_width = e.plan.pens && std::ranges::any_of(e.plan.pens->pens, [](const DrawnPen& pen) {
                   return pen.line.presses();
                 });
  if (e.plan.pens) h.attributes[kPensAttribute] = pens_text(*e.plan.pens);
  return h;
}

void fill_state(const Experiment& e, const Cycle& cycle, LogRow* row) {
  const ArmState& state = *cycle.state;
  const GroundTruth* const truth = cycle.truth;
  const ImpedanceTorque& out = cycle.out;
  const Pose& X_WE = truth ? truth->X_WE : cycle.arm.X_WE;
  row->time = cycle.run_time;
  row->joint_position = truth ? truth->q : state.q;
  row->joint_velocity = truth ? truth->v : state.v;
  row->joint_torque = out.tau;
  row->measured_position = state.q;
  row->measured_velocity = state.v;
  for (int k = 0; k < kTorqueTerms; ++k) row->torque_terms[k] = out.terms.col(k);
  row->tip_position = X_WE.p;
  row->tip_orientation = Eigen::Quaterniond(X_WE.R);
  row->tip_velocity = truth ? truth->V_WE : cycle.arm.V_WE;
  row->desired_position = out.p_WD;
  // The desired tip frame: −z along the desired normal, rotated about it like the current tip.
  row->desired_orientation = turn_between(X_WE.R.col(2), -out.axis_WD) * row->tip_orientation;
  const ImpedanceSettings& control = e.control.impedance;
  row->wrench_measured =
      control.wrench == WrenchFeedback::measured ? cycle.F_ext : Wrench(Wrench::Zero());
  const bool known = cycle.surface.status == SurfaceStatus::ok;
  row->surface_normal = known ? cycle.surface.n_W : LogRow::no_vector();
  row->surface_distance = known ? cycle.surface.distance : LogRow::kNone;
  // Blind, the stiffness and the set-point's depth produce the push.
  row->push = e.belief.estimates_surface()
                  ? out.push
                  : (cycle.desired.reference.pen_down ? control.normal_force : 0.0);
  row->mode = static_cast<int>(out.mode);
  row->stroke = cycle.desired.stroke;
  row->stroke_along = cycle.desired.along;
  if (truth) row->canvas_pose = truth->X_WK;
  const FrameMotion& canvas = cycle.canvas.estimate().motion;
  row->estimated_canvas_pose = canvas.X_WK;
  row->estimated_canvas_twist << canvas.v, canvas.w;
}

void fill_contact(const Experiment& e, const Cycle& cycle, LogRow* row) {
  const GroundTruth* const truth = cycle.truth;
  if (!truth) {
    const bool measured = e.control.impedance.wrench == WrenchFeedback::measured;
    const bool touches = cycle.out.mode == ContactMode::contact && row->surface_normal.allFinite();
    row->contact_force = !measured ? LogRow::no_vector()
                         : touches ? Eigen::Vector3d(row->wrench_measured.head<3>())
                                   : Eigen::Vector3d::Zero();
    row->canvas_pose = row->estimated_canvas_pose;
    const Pose X_KW = row->canvas_pose.inverse();
    row->contact_point =
        touches ? X_KW * (row->tip_position - row->surface_distance * row->surface_normal)
                : LogRow::no_vector();
    row->contact_normal =
        touches ? Eigen::Vector3d(X_KW.R * row->surface_normal) : LogRow::no_vector();
    return;
  }
  row->disturbance_force = truth->disturbance_force;
  row->contact_force = truth->contact_force;
  row->contact_point = truth->contact_point;
  row->contact_normal = truth->contact_normal;
  if (!e.plan.pens) return;
  const double f = normal_force(row->contact_force, row->contact_normal_W());
  row->line_width = is_ink(f) ? e.plan.pens->of(row->stroke).line.width_at(f) : LogRow::kNone;
}

}  // namespace impedraw

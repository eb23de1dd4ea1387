#include "app/run.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

namespace impedraw {

namespace {

using Clock = std::chrono::steady_clock;
constexpr double kRunaway = 20.0;  // joint speed [rad/s], near ten times what such an arm can

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

RunLogHeader make_header(const Experiment& e) {
  RunLogHeader h;
  h.joint_names = e.arm.joint_names();
  h.joint_lower = e.arm.limits().lower;
  h.joint_upper = e.arm.limits().upper;
  h.torque_limit = e.arm.limits().torque;
  for (const std::string_view name : kTorqueTermNames) h.torque_terms.emplace_back(name);
  for (const std::string_view name : kContactModeNames) h.mode_names.emplace_back(name);
  h.canvas_vertices = e.canvas->mesh().vertices;
  h.canvas_triangles = e.canvas->mesh().triangles;
  if (e.perception) {
    h.cloud_points = e.perception->cloud().points;
    h.cloud_normals = e.perception->cloud().normals;
    h.cloud_camera = e.perception->cloud().camera;
  }
  h.target_points = e.target.points;
  h.target_stroke = e.target.stroke;
  h.attributes = {{"scenario", e.scenario.name}, {"seed", std::to_string(e.scenario.seed)}};
  return h;
}

// The frame that the tip is asked into: −z along the wanted normal, turned about it as the tip is now.
Eigen::Quaterniond wanted_orientation(const Eigen::Matrix3d& R_WE, const Eigen::Vector3d& n_WD) {
  return Eigen::Quaterniond::FromTwoVectors(R_WE.col(2), -n_WD) * Eigen::Quaterniond(R_WE);
}

Eigen::Vector3d push_on_pen(const Experiment& e, double time, const Eigen::Vector3d& n_W) {
  const auto& strokes = e.path.strokes();
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const PushSettings& push : e.scenario.pushes) {
    const double middle = strokes.front().start + push.middle * (strokes.back().end - strokes.front().start);
    if (std::abs(time - middle) > 0.5 * push.duration) continue;
    const Eigen::Vector3d along = push.direction_W - n_W * n_W.dot(push.direction_W);
    if (along.norm() > 1e-9) force += push.force * along.normalized();
  }
  return force;
}

int stroke_number(const TipPath& path, double time) {
  const auto& strokes = path.strokes();
  const auto next = std::upper_bound(strokes.begin(), strokes.end(), time, [](double t, const StrokeTimes& s) { return t < s.approach; });
  return static_cast<int>(next - strokes.begin());
}

}  // namespace

RunOutcome run(Experiment& e, const std::filesystem::path& log_file, double start_up, const RunHooks& hooks) {
  const auto before_log = Clock::now();
  const int n = e.arm.joints();
  World& world = *e.world;
  world.set_state(e.start_q, JointVector::Zero(n));
  ImpedanceController controller(e.control, n);
  RunLog log(log_file, make_header(e));
  LogRow row(n);
  ArmTerms terms(n);
  SurfaceEstimate surface;
  Wrench F_ext = Wrench::Zero();
  const bool measured = e.control.wrench == WrenchFeedback::measured;
  RunOutcome outcome;
  outcome.wall.start_up = start_up + seconds_since(before_log);

  const auto loop_start = Clock::now();
  const long steps = std::lround(std::ceil(e.path.duration() / e.scenario.world.dt));
  for (long i = 0; i < steps; ++i) {
    const WorldState& state = world.state();
    const double t = state.time;
    const PathSample wanted = e.path.at(t);

    const auto step_start = Clock::now();
    e.arm.compute(state.q, state.v, &terms);
    if (e.perception) surface = e.perception->estimate(terms.X_WE.p);
    const ImpedanceTorque& out = controller.step(terms, wanted.goal, surface, F_ext);
    row.step_time = seconds_since(step_start);

    row.time = t;
    row.joint_position = state.q;
    row.joint_velocity = state.v;
    row.joint_torque = out.tau;
    for (int k = 0; k < kTorqueTerms; ++k) row.torque_terms[k] = out.terms.col(k);
    row.tip_position = state.X_WE.p;
    row.tip_orientation = Eigen::Quaterniond(state.X_WE.R);
    row.tip_velocity = state.V_WE;
    row.desired_position = out.p_WD;
    row.desired_orientation = wanted_orientation(state.X_WE.R, out.n_WD);
    row.wrench_measured = measured ? F_ext : Wrench(Wrench::Zero());
    const bool known = surface.status == SurfaceStatus::ok;
    row.surface_normal = known ? surface.n_W : LogRow::no_vector();
    row.surface_distance = known ? surface.distance : LogRow::kNone;
    // Blind, the stiffness is to make the push that the set-point's depth was chosen for.
    row.push = e.perception ? out.push : (wanted.goal.pen_down ? e.control.push_force : 0.0);
    row.mode = static_cast<int>(out.mode);
    row.stroke = wanted.stroke;

    Eigen::Vector3d push = Eigen::Vector3d::Zero();
    if (!e.scenario.pushes.empty()) push = push_on_pen(e, t, e.canvas->closest(state.X_WE.p).n_W);
    const Eigen::Vector3d p_WE = state.X_WE.p;
    const TipContact& contact = world.step(out.tau, push);
    row.disturbance_force = push;
    row.contact_force = contact.f_W;
    row.contact_point = contact.touching ? contact.p_WC : LogRow::no_vector();
    row.contact_normal = contact.touching ? contact.n_W : LogRow::no_vector();
    log.append(row);

    F_ext << contact.f_W + push, (contact.p_WC - p_WE).cross(contact.f_W);
    Eigen::Index fastest = 0;
    const double speed = world.state().v.cwiseAbs().maxCoeff(&fastest);
    if (world.failure()) {
      outcome.cause = *world.failure();
    } else if (!(speed < kRunaway)) {
      outcome.cause = fmt::format("the motion went unstable at t = {:.3f} s: {} turns at {:.1f} rad/s, the limit is {:.0f} rad/s",
                                  world.state().time, e.arm.joint_names()[static_cast<std::size_t>(fastest)], speed, kRunaway);
    } else if (out.status.bad_input) {
      outcome.cause = fmt::format("the controller was given a number that is not finite at t = {:.3f} s", t);
    }
    if (!outcome.cause.empty()) {
      outcome.end = RunEnd::stopped;
      break;
    }
    if (i % 10 == 0) {
      if (hooks.interrupted && hooks.interrupted()) {
        outcome.end = RunEnd::interrupted;
        outcome.cause = fmt::format("interrupted at t = {:.3f} s", t);
        break;
      }
      if (hooks.progress)
        hooks.progress({t, e.path.duration(), stroke_number(e.path, t), static_cast<int>(e.path.strokes().size()), t / e.path.duration()});
    }
  }
  outcome.simulated = world.state().time;
  outcome.wall.loop = seconds_since(loop_start);
  outcome.wall = log.close(outcome.wall);
  return outcome;
}

}  // namespace impedraw

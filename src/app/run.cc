#include "app/run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "app/lift_out.h"
#include "app/wall_time.h"
#include "app/wrench_input.h"
#include "control/step_watchdog.h"

namespace impedraw {

namespace {

constexpr double kRunaway = 20.0;  // joint speed [rad/s], near ten times what such an arm can

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

// When that share of the way from the first stroke's start to the last one's end is over [s].
double time_at(const Experiment& e, double share) {
  const auto& strokes = e.path.strokes();
  return strokes.front().start + share * (strokes.back().end - strokes.front().start);
}

Eigen::Vector3d push_on_pen(const Experiment& e, double time, const Eigen::Vector3d& n_W) {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const PushSettings& push : e.scenario.pushes) {
    if (std::abs(time - time_at(e, push.middle)) > 0.5 * push.duration) continue;
    const Eigen::Vector3d along = push.direction_W - n_W * n_W.dot(push.direction_W);
    if (along.norm() > 1e-9) force += push.force * along.normalized();
    force += push.lift * n_W;
  }
  return force;
}

const FaultSettings* fault_at(const Experiment& e, double time, FaultKind kind) {
  for (const FaultSettings& fault : e.scenario.faults) {
    const double start = time_at(e, fault.middle);
    if (fault.kind == kind && time >= start && time < start + fault.duration) return &fault;
  }
  return nullptr;
}

// The controller and all that feeds it, with the faults that the scenario puts in between.
class ControlLoop {
 public:
  explicit ControlLoop(Experiment& e)
      : e_(e), controller_(e.control, e.arm.joints()), wrench_(e.scenario.control.source, e.estimator, e.sensor, e.control.dt,
                                                               static_cast<std::uint64_t>(e.scenario.seed)),
        terms_(e.arm.joints()), q_(e.start_q), v_(JointVector::Zero(e.arm.joints())) {}

  const ImpedanceTorque& step(const World& world, const TipGoal& goal) noexcept {
    const double t = world.state().time;
    wrench_.sample(world);
    InputAges ages;
    if (!fault_at(e_, t, FaultKind::stale_state)) {
      q_ = world.state().q;
      v_ = world.state().v;
      state_time_ = t;
    }
    ages.state = t - state_time_;
    if (fault_at(e_, t, FaultKind::nan_state)) v_[0] = std::nan("");

    e_.arm.compute(q_, v_, &terms_);
    if (e_.perception) {
      const bool coupled = e_.control.inertia != InertiaShaping::shaped;
      surface_ = e_.perception->estimate(coupled && on_surface_ ? surface_query(terms_.X_WE.p, goal.p_WD, n_) : terms_.X_WE.p);
    }
    if (e_.perception && fault_at(e_, t, FaultKind::no_cloud)) surface_.status = SurfaceStatus::too_few;
    if (!fault_at(e_, t, FaultKind::stale_wrench)) {
      F_ext_ = wrench_.estimate(terms_.X_WE, terms_.V_WE);
      wrench_time_ = t;
    }
    ages.wrench = t - wrench_time_;
    if (fault_at(e_, t, FaultKind::nan_wrench)) F_ext_[2] = std::nan("");
    const ImpedanceTorque& out = controller_.step(terms_, goal, surface_, F_ext_, ages);
    on_surface_ = out.mode == ContactMode::approach || out.mode == ContactMode::contact;
    n_ = out.n_WD;
    return out;
  }

  WrenchInput& wrench() { return wrench_; }
  const Wrench& F_ext() const { return F_ext_; }
  const SurfaceEstimate& surface() const { return surface_; }

 private:
  Experiment& e_;
  ImpedanceController controller_;
  WrenchInput wrench_;
  ArmTerms terms_;
  SurfaceEstimate surface_;
  Wrench F_ext_ = Wrench::Zero();
  Eigen::Vector3d n_ = Eigen::Vector3d::UnitZ();  // of the last step
  bool on_surface_ = false;
  JointVector q_, v_;
  double state_time_ = 0.0, wrench_time_ = 0.0;
};

void count_status(const ControlStatus& status, double dt, std::map<std::string, double>* met) {
  if (status.ok()) return;
  const std::pair<const char*, bool> all[] = {{"bad_input", status.bad_input},         {"stale_state", status.stale_state},
                                              {"stale_wrench", status.stale_wrench},   {"near_singular", status.near_singular},
                                              {"torque_limited", status.torque_limited}, {"speed_limited", status.speed_limited},
                                              {"joint_limit", status.joint_limit},     {"surface_lost", status.surface_lost},
                                              {"damping_limit", status.damping_limit}};
  for (const auto& [name, set] : all)
    if (set) (*met)[name] += dt;
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
  const double dt = e.scenario.world.dt;
  World& world = *e.world;
  world.set_state(e.start_q, JointVector::Zero(n));
  ControlLoop loop(e);
  StepWatchdog watchdog;
  RunLog log(log_file, make_header(e));
  LogRow row(n);
  ImpedanceTorque out;
  const bool measured = e.control.wrench == WrenchFeedback::measured;
  RunOutcome outcome;
  std::optional<LiftOut> lifting;
  double bad_state = 0.0, stalled = 0.0;
  outcome.wall.start_up = start_up + seconds_since(before_log);
  const auto stop = [&outcome](RunEnd end, const std::string& cause) {
    if (outcome.end != RunEnd::finished) return;
    outcome.end = end;
    outcome.cause = cause;
  };

  const auto loop_start = Clock::now();
  const long steps = std::lround(std::ceil(e.path.duration() / dt));
  for (long i = 0; i < steps || lifting; ++i) {
    const WorldState& state = world.state();
    const double t = state.time;
    if (lifting && lifting->done(t)) break;
    PathSample wanted = e.path.at(t);
    if (lifting) wanted = {lifting->at(t), -1, Phase::lift};

    const auto step_start = Clock::now();
    // A step that takes long leaves the drives with the torque that they have; the loop's next input is what there is then.
    double step_time = 0.0;  // as the watchdog is told: the simulator waits for the controller, so only what a fault adds
    if (fault_at(e, t, FaultKind::slow_step)) {
      stalled += dt;
    } else {
      out = loop.step(world, wanted.goal);
      step_time = std::exchange(stalled, 0.0);
    }
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
    row.wrench_measured = measured ? loop.F_ext() : Wrench(Wrench::Zero());
    const bool known = loop.surface().status == SurfaceStatus::ok;
    row.surface_normal = known ? loop.surface().n_W : LogRow::no_vector();
    row.surface_distance = known ? loop.surface().distance : LogRow::kNone;
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

    Wrench F_true;
    F_true << contact.f_W + push, (contact.p_WC - p_WE).cross(contact.f_W);
    loop.wrench().set_true(F_true);
    count_status(out.status, dt, &outcome.met);

    Eigen::Index fastest = 0;
    const double speed = world.state().v.cwiseAbs().maxCoeff(&fastest);
    const bool blind_to_state = out.status.bad_input || out.status.stale_state;
    bad_state = blind_to_state ? bad_state + dt : 0.0;
    std::string lost;  // beyond what lifting the pen could mend
    if (world.failure()) {
      lost = *world.failure();
    } else if (!(speed < kRunaway)) {
      lost = fmt::format("the motion went unstable at t = {:.3f} s: {} turns at {:.1f} rad/s, the limit is {:.0f} rad/s",
                         world.state().time, e.arm.joint_names()[static_cast<std::size_t>(fastest)], speed, kRunaway);
    } else if (bad_state > kBadStateTime) {
      lost = fmt::format("the controller was given {} for {:.1f} s up to t = {:.3f} s",
                         out.status.bad_input ? "numbers that are not finite" : "joint states that are stale", kBadStateTime, t);
    }
    if (lost.empty() && t > e.start_hold && !loop.wrench().tared())
      lost = fmt::format("the wrench sensor could not be tared: within the first {:.2g} s the arm must rest for {:.2g} s, with no reading at its range",
                         e.start_hold, e.estimator.tare_time);
    if (!lost.empty()) {
      stop(RunEnd::stopped, lost);
      break;
    }
    const auto lift = [&] {
      if (!lifting) lifting.emplace(t + dt, world.state().X_WE.p, out.n_WD);
    };
    if (watchdog.update(step_time)) {
      stop(RunEnd::stopped, fmt::format("a control step took too long at t = {:.3f} s; the pen was lifted", t));
      lift();
    }
    if (i % 10 == 0) {
      if (!lifting && hooks.interrupted && hooks.interrupted()) {
        stop(RunEnd::interrupted, fmt::format("interrupted at t = {:.3f} s; the pen was lifted", t));
        lift();
      }
      if (hooks.progress)
        hooks.progress({t, e.path.duration(), stroke_number(e.path, t), static_cast<int>(e.path.strokes().size()),
                        std::min(1.0, t / e.path.duration())});
    }
  }
  outcome.simulated = world.state().time;
  outcome.wall.loop = seconds_since(loop_start);
  outcome.wall = log.close(outcome.wall);
  return outcome;
}

}  // namespace impedraw

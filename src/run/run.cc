#include "impedraw/run/run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "impedraw/control/step_watchdog.h"
#include "impedraw/run/control_loop.h"
#include "impedraw/run/emergency_lift.h"
#include "impedraw/terminal/clock.h"

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
  h.rate = e.scenario.log.rate;
  h.dt = e.scenario.world.dt;
  h.attributes = {{"scenario", e.scenario.name}, {"seed", std::to_string(e.scenario.seed)}};
  return h;
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

void count_status(const ControlStatus& status, double dt, std::map<std::string, double>* met) {
  if (status.ok()) return;
  const std::pair<const char*, bool> all[] = {
      {"bad_input", status.bad_input},           {"stale_state", status.stale_state},
      {"stale_wrench", status.stale_wrench},     {"near_singular", status.near_singular},
      {"torque_limited", status.torque_limited}, {"speed_limited", status.speed_limited},
      {"joint_limit", status.joint_limit},       {"surface_lost", status.surface_lost},
      {"damping_limit", status.damping_limit}};
  for (const auto& [name, set] : all)
    if (set) (*met)[name] += dt;
}

// How far along the path the pen has come: strokes begun, and pen-down length.
class Odometer {
 public:
  explicit Odometer(const TipPath& path) : path_(path), before_(1, 0.0) {
    for (const StrokeTimes& s : path.strokes()) before_.push_back(before_.back() + s.length);
  }
  void read(double t, RunProgress* progress) const {
    const auto& strokes = path_.strokes();
    const auto begun =
        std::upper_bound(strokes.begin(), strokes.end(), t,
                         [](double at, const StrokeTimes& s) { return at < s.approach; });
    const auto i = static_cast<std::size_t>(begun - strokes.begin());
    progress->stroke = static_cast<int>(i);
    progress->strokes = static_cast<int>(strokes.size());
    progress->length = before_.back();
    progress->drawn = before_[i];
    if (i == 0) return;
    const StrokeTimes& s = strokes[i - 1];
    const double share = s.end > s.start ? std::clamp((t - s.start) / (s.end - s.start), 0.0, 1.0)
                                         : (t >= s.end ? 1.0 : 0.0);
    progress->drawn -= (1.0 - share) * s.length;
  }

 private:
  const TipPath& path_;
  std::vector<double> before_;  // [m]
};

class Runner {
 public:
  Runner(Experiment& e, const std::filesystem::path& log_file, const RunHooks& hooks,
         const Resumption* resumption)
      : e_(e),
        hooks_(hooks),
        first_time_(resumption ? resumption->time : 0.0),
        loop_(e, !resumption),
        log_(resumption ? RunLog::append_to(log_file, make_header(e))
                        : RunLog(log_file, make_header(e))),
        row_(e.arm.joints()) {
    if (resumption) ink_ = resumption->ink;
  }

  // Follows the path from its beginning to its end, or until something stops the run.
  void follow(const TipPath& path, bool again) {
    const double dt = e_.scenario.world.dt, begin = e_.world->state().time;
    const Odometer odometer(path);
    const long steps = std::lround(std::ceil(path.duration() / dt));
    for (long i = 0; i < steps || lifting_; ++i) {
      const double t = e_.world->state().time;
      if (lifting_ && lifting_->done(t)) return;
      PathSample desired = path.at(t - begin);
      if (lifting_) desired = {lifting_->at(t), -1, std::nan(""), Phase::lift};
      if (!step(desired)) return;
      if (i % 10 != 0) continue;
      if (!lifting_ && hooks_.interrupted && hooks_.interrupted()) {
        stop(RunEnd::interrupted,
             fmt::format("interrupted at t = {:.3f} s; the pen was lifted", t));
        lift();
      }
      if (!hooks_.progress) continue;
      RunProgress progress{t, 0, 0, 0.0, 0.0, std::min(1.0, (t - begin) / path.duration()), again};
      odometer.read(t - begin, &progress);
      hooks_.progress(progress);
    }
  }

  RunOutcome& outcome() { return outcome_; }
  RunLog& log() { return log_; }
  const InkWatch& ink() const { return ink_; }

 private:
  // One control step, logged. False where the run is over.
  bool step(const PathSample& desired) {
    World& world = *e_.world;
    const double dt = e_.scenario.world.dt, t = world.state().time;
    const auto step_start = Clock::now();
    // A step that takes long leaves the drives with the torque that they have; the loop's next
    // input is what there is then.
    // as the watchdog is told: the simulator waits for the controller, so only what a fault adds
    double step_time = 0.0;
    if (first_time_ == 0.0 && fault_at(e_, t, FaultKind::slow_step)) {
      stalled_ += dt;
    } else {
      out_ = loop_.step(world, desired.reference);
      step_time = std::exchange(stalled_, 0.0);
    }
    row_.step_time = seconds_since(step_start);

    Eigen::Vector3d push = Eigen::Vector3d::Zero();
    if (!e_.scenario.pushes.empty() && first_time_ == 0.0)
      push = push_on_pen(e_, t, e_.canvas->closest(world.state().X_WE.p).n_W);
    fill_row(world.state(), desired);
    const Eigen::Vector3d p_WE = world.state().X_WE.p;
    const TipContact& contact = world.step(out_.tau, push);
    row_.disturbance_force = push;
    row_.contact_force = contact.f_W;
    row_.contact_point = contact.touching ? contact.p_WC : LogRow::no_vector();
    row_.contact_normal = contact.touching ? contact.n_W : LogRow::no_vector();
    log_.append(row_);

    Wrench F_true;
    F_true << contact.f_W + push, (contact.p_WC - p_WE).cross(contact.f_W);
    loop_.wrench().set_true(F_true);
    count_status(out_.status, dt, &outcome_.met);
    ink_.add(desired.stroke, desired.along,
             writes(e_, out_.mode, loop_.F_ext().head<3>().dot(out_.n_WD)));

    const std::string lost = lost_control(t);
    if (!lost.empty()) {
      stop(RunEnd::stopped, lost);
      return false;
    }
    if (watchdog_.update(step_time)) {
      stop(RunEnd::stopped,
           fmt::format("a control step took too long at t = {:.3f} s; the pen was lifted", t));
      lift();
    }
    return true;
  }

  void fill_row(const WorldState& state, const PathSample& desired) {
    row_.time = first_time_ + state.time;
    row_.joint_position = state.q;
    row_.joint_velocity = state.v;
    row_.joint_torque = out_.tau;
    for (int k = 0; k < kTorqueTerms; ++k) row_.torque_terms[k] = out_.terms.col(k);
    row_.tip_position = state.X_WE.p;
    row_.tip_orientation = Eigen::Quaterniond(state.X_WE.R);
    row_.tip_velocity = state.V_WE;
    row_.desired_position = out_.p_WD;
    // The frame that the tip is asked into: −z along the desired normal, turned about it as the tip
    // is now.
    row_.desired_orientation =
        Eigen::Quaterniond::FromTwoVectors(state.X_WE.R.col(2), -out_.n_WD) * row_.tip_orientation;
    row_.wrench_measured =
        e_.control.wrench == WrenchFeedback::measured ? loop_.F_ext() : Wrench(Wrench::Zero());
    const bool known = loop_.surface().status == SurfaceStatus::ok;
    row_.surface_normal = known ? loop_.surface().n_W : LogRow::no_vector();
    row_.surface_distance = known ? loop_.surface().distance : LogRow::kNone;
    // Blind, the stiffness is to make the push that the set-point's depth was chosen for.
    row_.push =
        e_.perception ? out_.push : (desired.reference.pen_down ? e_.control.normal_force : 0.0);
    row_.mode = static_cast<int>(out_.mode);
    row_.stroke = desired.stroke;
    row_.stroke_along = desired.along;
  }

  // Why the run cannot go on, beyond what lifting the pen could mend; empty: it can.
  std::string lost_control(double t) {
    const World& world = *e_.world;
    Eigen::Index fastest = 0;
    const double speed = world.state().v.cwiseAbs().maxCoeff(&fastest);
    const bool blind_to_state = out_.status.bad_input || out_.status.stale_state;
    bad_state_ = blind_to_state ? bad_state_ + e_.scenario.world.dt : 0.0;
    if (world.failure()) return *world.failure();
    if (!(speed < kRunaway))
      return fmt::format(
          "the motion went unstable at t = {:.3f} s: {} turns at {:.1f} rad/s, the limit is {:.0f} "
          "rad/s",
          world.state().time, e_.arm.joint_names()[static_cast<std::size_t>(fastest)], speed,
          kRunaway);
    if (bad_state_ > kBadStateTime)
      return fmt::format(
          "the controller was given {} for {:.1f} s up to t = {:.3f} s",
          out_.status.bad_input ? "numbers that are not finite" : "joint states that are stale",
          kBadStateTime, t);
    if (t > e_.start_hold && !loop_.wrench().tared())
      return fmt::format(
          "the wrench sensor could not be tared: within the first {:.2g} s the arm must rest for "
          "{:.2g} s, with no reading at its range",
          e_.start_hold, e_.estimator.tare_time);
    return {};
  }

  void stop(RunEnd end, const std::string& cause) {
    if (outcome_.end != RunEnd::finished) return;
    outcome_.end = end;
    outcome_.cause = cause;
  }

  void lift() {
    if (!lifting_) lifting_.emplace(e_.world->state().time, e_.world->state().X_WE.p, out_.n_WD);
  }

  Experiment& e_;
  const RunHooks& hooks_;
  double first_time_;  // of the log, where an earlier run left off [s]
  ControlLoop loop_;
  StepWatchdog watchdog_;
  RunLog log_;
  LogRow row_;
  ImpedanceTorque out_;
  InkWatch ink_;
  RunOutcome outcome_;
  std::optional<EmergencyLift> lifting_;
  double bad_state_ = 0.0, stalled_ = 0.0;
};

// What to draw for those parts to have ink, begun and ended in the ink beside them.
std::vector<PlacedStroke> strokes_of(const Experiment& e, const std::vector<StrokePart>& parts) {
  std::vector<PlacedStroke> strokes;
  for (const StrokePart& part : parts)
    strokes.push_back(part_of(e.strokes[static_cast<std::size_t>(part.stroke)],
                              part.from - kRedrawOverlap, part.to + kRedrawOverlap));
  return strokes;
}

}  // namespace

bool writes(const Experiment& e, ContactMode mode, double normal_force) {
  const bool measured = e.control.wrench == WrenchFeedback::measured;
  if (measured && !(normal_force >= InkWatch::least_force(e.control.normal_force))) return false;
  // Blind, the law knows no contact; without a wrench either, nobody can tell.
  return !e.perception || mode == ContactMode::contact;
}

RunOutcome run(Experiment& e, const std::filesystem::path& log_file, double start_up,
               const RunHooks& hooks, const Resumption* resumption) {
  const auto before_log = Clock::now();
  const JointVector q = resumption ? resumption->q : e.start_q;
  e.world->set_state(q, JointVector::Zero(e.arm.joints()));
  Runner runner(e, log_file, hooks, resumption);
  RunOutcome& outcome = runner.outcome();
  TipPath rest;
  if (resumption) {
    const Pose X_WE = e.arm.tip_pose(q);
    const std::vector<StrokePart> parts = rest_of(e.strokes, resumption->ink.parts(), kShortestGap);
    if (!parts.empty())
      rest = plan_from(e, strokes_of(e, parts), X_WE.p, -X_WE.R.col(2), e.start_hold);
  }
  outcome.wall.start_up = start_up + seconds_since(before_log);

  const auto loop_start = Clock::now();
  const TipPath& path = resumption ? rest : e.path;
  runner.follow(path, false);
  const auto lacking = [&] { return rest_of(e.strokes, runner.ink().parts(), kShortestGap); };
  if (outcome.end == RunEnd::finished && e.scenario.drawing.redraw &&
      !(outcome.drawn_again = lacking()).empty()) {
    const PathSample last = path.at(path.duration());
    runner.follow(plan_from(e, strokes_of(e, outcome.drawn_again), last.reference.p_WD,
                            last.reference.n_WD, 0.0),
                  true);
  }
  if (outcome.end == RunEnd::finished) outcome.lacking = lacking();
  outcome.simulated = e.world->state().time;
  outcome.wall.loop = seconds_since(loop_start);
  outcome.wall = runner.log().close(outcome.wall);
  return outcome;
}

}  // namespace impedraw

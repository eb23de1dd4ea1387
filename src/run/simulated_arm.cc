#include "impedraw/run/simulated_arm.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "impedraw/terminal/progress.h"

namespace impedraw {
namespace {

constexpr double kMostBrush = 1.0;  // a shaft that touches for longer does not get away [s]
constexpr double kRunaway = 20.0;   // joint speed [rad/s], near ten times what such an arm can

// Refers to the drawing.
DriverMaker simulated(Prepared& e) {
  if (e.scenario.arm.driver != ArmDriver::sim)
    throw InputError(
        "arm.driver is not sim, and only ./impedraw draw drives such an arm; valid here is sim");
  return [&e](const JointVector& start_q, const Resumption* resumed) {
    return std::make_unique<SimulatedArm>(e, start_q, disturbances_of(e, resumed != nullptr),
                                          resumed ? resumed->time : 0.0);
  };
}

PrepareProgress shown_on(ProgressLine& line) {
  return [&line](const char* what, double share) { line.update(what, share); };
}

}  // namespace

SimulatedArm::SimulatedArm(Prepared& e, const JointVector& start_q, Disturbances disturbances,
                           double first_time)
    : scenario_(e.scenario),
      world_(*e.truth.world),
      canvas_(*e.truth.canvas),
      arm_(e.belief.arm),
      camera_corrections_(e.belief.camera_corrections),
      start_q_(start_q),
      joint_names_(e.belief.arm.joint_names()),
      dt_(e.scenario.world.dt),
      first_time_(first_time),
      disturbances_(std::move(disturbances)),
      source_(e.control.source),
      sensor_settings_(e.control.sensor),
      seed_(static_cast<std::uint64_t>(e.scenario.seed)),
      joint_sensor_settings_(e.scenario.world.joint_sensor),
      state_(world_.joints()) {
  for (const LinkPush& push : disturbances_.link_pushes())
    pushed_links_.push_back(world_.link(push.link).value());  // checked with the scene
}

DriverInfo SimulatedArm::info() const {
  const WrenchReading wrench = source_ == WrenchSource::none ? WrenchReading::none
                               : has_sensor(source_)         ? WrenchReading::sensor
                                                             : WrenchReading::tip;
  return {world_.joints(), dt_, wrench, joint_sensor_settings_.velocity != VelocityReading::none};
}

void SimulatedArm::start() {
  world_.canvas_moved_for(first_time_);
  world_.set_state(start_q_, JointVector::Zero(world_.joints()));
  if (has_sensor(source_)) sensor_.emplace(sensor_settings_, dt_, seed_);
  if (!joint_sensor_settings_.exact())
    joint_sensor_.emplace(joint_sensor_settings_, world_.joints(), dt_, ~seed_);
  const PerceptionSettings& p = scenario_.perception;
  if (p.frames.enabled && p.source != PerceptionSource::capture)
    cameras_.emplace(scenario_, world_, canvas_, arm_, camera_corrections_);
  state_ = ArmState(world_.joints());
  truth_ = GroundTruth();
  tip_wrench_.setZero();
  stalled_ = brushed_ = 0.0;
  fault_.clear();
}

const ArmState& SimulatedArm::read() noexcept {
  const WorldState& now = world_.state();
  truth_.q = now.q;
  truth_.v = now.v;
  truth_.X_WE = now.X_WE;
  truth_.V_WE = now.V_WE;
  if (world_.canvas_motion().moves()) truth_.X_WK = world_.canvas_state().X_WK;
  look_for_faults();

  if (cameras_) cameras_->expose(disturbances_.fault(FaultKind::no_frames, now.time));

  state_.time = now.time;
  state_.stalled = disturbances_.fault(FaultKind::slow_step, now.time);
  // The simulator waits for the controller: only what the fault adds is told.
  state_.step_time = state_.stalled ? 0.0 : std::exchange(stalled_, 0.0);
  if (state_.stalled) {
    stalled_ += dt_;
  } else {
    read_joints(now);
    read_wrench(now.time);
  }
  return state_;
}

void SimulatedArm::read_joints(const WorldState& now) noexcept {
  const JointReading* read =
      joint_sensor_ ? &joint_sensor_->sample(world_.sensed_q(), world_.sensed_v()) : nullptr;
  const auto acts = [&](FaultKind kind) { return disturbances_.fault(kind, now.time); };
  if (!acts(FaultKind::stale_state)) {
    state_.state_time = now.time;
    if (!acts(FaultKind::standing_state)) {
      state_.q = read ? read->q : world_.sensed_q();
      state_.v = read ? read->v : world_.sensed_v();
      if (acts(FaultKind::jumped_state)) state_.q[0] += 0.5;
      state_.q[0] += 0.3 * std::max(0.0, disturbances_.since(FaultKind::drifting_state, now.time));
    } else {
      state_.v.setZero();
    }
  }
  if (acts(FaultKind::false_speed)) state_.v[0] = 9.0;
  if (acts(FaultKind::nan_state)) state_.v[0] = std::numeric_limits<double>::quiet_NaN();
}

void SimulatedArm::read_wrench(double time) noexcept {
  const Vector6 wrench = sensor_ ? sensor_->sample(world_.flange_wrench()) : tip_wrench_;
  if (source_ == WrenchSource::none) return;
  if (!disturbances_.fault(FaultKind::stale_wrench, time)) {
    state_.wrench = wrench;
    state_.wrench_time = time;
  }
  if (disturbances_.fault(FaultKind::future_wrench, time)) state_.wrench_time = time + 3600.0;
  if (disturbances_.fault(FaultKind::false_wrench, time)) state_.wrench[2] = wrench[2] + 200.0;
  if (disturbances_.fault(FaultKind::nan_wrench, time))
    state_.wrench[2] = std::numeric_limits<double>::quiet_NaN();
}

// A thing that no camera saw brushes the pen's shaft: a measured wrench would tell, and the run
// gives the place up as one before a wall.
bool SimulatedArm::feels_shaft() {
  const std::string& link = world_.touching_link();
  const bool shaft = !link.empty() && world_.below_flange(*world_.link(link));
  brushed_ = shaft ? brushed_ + dt_ : 0.0;
  if (!shaft || source_ == WrenchSource::none || !scenario_.perception.enabled ||
      world_.canvas_motion().moves() || brushed_ > kMostBrush)
    return false;
  world_.forget_touching_link();
  return true;
}

void SimulatedArm::look_for_faults() {
  if (!fault_.empty()) return;
  state_.shaft_touches = feels_shaft();
  const WorldState& now = world_.state();
  Eigen::Index fastest = 0;
  const double speed = now.v.cwiseAbs().maxCoeff(&fastest);
  if (world_.failure())
    fault_ = fmt::format("the motion went unstable at t = {:.3f} s: {}", first_time_ + now.time,
                         *world_.failure());
  else if (!(speed < kRunaway))
    fault_ = fmt::format(
        "the motion went unstable at t = {:.3f} s: {} turns at {:.1f} rad/s, the limit is {:.0f} "
        "rad/s",
        first_time_ + now.time, joint_names_[static_cast<std::size_t>(fastest)], speed, kRunaway);
  else if (!world_.touching_link().empty())
    fault_ = fmt::format("{} touched the canvas at t = {:.3f} s; only the tip may",
                         world_.touching_link(), first_time_ + now.time);
}

void SimulatedArm::put_in(int number) noexcept {
  const ModelErrors& errors = scenario_.world.errors;
  TipMaterial tip = true_tip(scenario_);
  double longer = errors.pen_longer;
  if (const auto i = static_cast<std::size_t>(number); number >= 0) {
    const LayerPenSettings& pen = scenario_.pens[i];
    if (i < errors.pens_longer.size()) longer = errors.pens_longer[i];
    longer += pen.longer.value_or(0.0);
    tip.radius = pen.radius.value_or(tip.radius);
  }
  world_.set_tip(tip);
  world_.set_pen_longer(longer + stand_off_of(scenario_.tool));
}

void SimulatedArm::command(const JointVector& tau, const JointVector&) noexcept {
  Eigen::Vector3d push = Eigen::Vector3d::Zero();
  const Eigen::Vector3d p_WE = truth_.X_WE.p;
  if (disturbances_.any_push())
    push = disturbances_.push(world_.state().time,
                              truth_.X_WK.R * canvas_.closest(truth_.X_WK.inverse() * p_WE).n_W);
  for (std::size_t i = 0; i < pushed_links_.size(); ++i)
    if (const LinkPush& on = disturbances_.link_pushes()[i]; on.acts(world_.state().time))
      world_.push_link(pushed_links_[i], on.force_W);
  const TipContact& contact = world_.step(tau, push);
  truth_.contact_force = contact.f_W;
  truth_.contact_point = contact.touching ? contact.p_WC : GroundTruth::no_vector();
  truth_.contact_normal = contact.touching ? contact.n_W : GroundTruth::no_vector();
  if (contact.touching && world_.canvas_motion().moves()) {
    truth_.contact_point = truth_.X_WK.inverse() * contact.p_WC;
    truth_.contact_normal = truth_.X_WK.R.transpose() * contact.n_W;
  }
  truth_.disturbance_force = push;
  truth_.cutoffs = world_.cutoffs();
  tip_wrench_ << contact.f_W + push, (contact.p_WC - p_WE).cross(contact.f_W);
  if (!contact.m_W.isZero(0.0)) tip_wrench_.tail<3>() += contact.m_W;
}

// Accelerations are central differences.
bool SimulatedArm::true_canvas(double time, FrameMotion* motion) const noexcept {
  constexpr double kStep = 1e-4;  // [s]
  const CanvasMotion& canvas = world_.canvas_motion();
  if (!canvas.moves()) return false;
  const auto state_at = [&](double t, Eigen::Vector3d* v) {
    const CanvasMotion::State state = canvas.at(t);
    *v = state.velocity_at(state.X_WK.p);
    return state;
  };
  Eigen::Vector3d v, v_before, v_after;
  const double t = first_time_ + time;
  const CanvasMotion::State now = state_at(t, &v), before = state_at(t - kStep, &v_before),
                            after = state_at(t + kStep, &v_after);
  *motion = {now.X_WK, v, (v_after - v_before) / (2.0 * kStep), now.w,
             (after.w - before.w) / (2.0 * kStep)};
  return true;
}

RunOutcome run(Prepared& e, const std::filesystem::path& log_file, double start_up,
               const RunHooks& hooks, const Resumption* resumption) {
  const auto arm = simulated(e)(resumption ? resumption->q : e.belief.start_q, resumption);
  return run(e, *arm, log_file, start_up, hooks, resumption);
}

Drawing draw_into(const std::filesystem::path& folder, Prepared& e, double start_up, bool resume,
                  const RunHooks& watch, const DriverMaker& make_driver, const FolderLock* held) {
  return draw_into(folder, e, make_driver ? make_driver : simulated(e), start_up, resume, watch,
                   held);
}

Prepared prepare_visibly(const Scenario& scenario, const Places& places) {
  ProgressLine line;
  return prepare(scenario, places, Unreachable::refuse, shown_on(line), nullptr,
                 PlanSummary::beside);
}

PreparedPlan prepare_plan_visibly(const Scenario& scenario, const Places& places) {
  ProgressLine line;
  PreparedPlan drawing = prepare_plan(scenario, places, Unreachable::tell, shown_on(line), nullptr,
                                      PlanSummary::beside);
  control_for(&drawing, places);
  return drawing;
}

}  // namespace impedraw

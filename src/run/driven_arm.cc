#include "impedraw/run/driven_arm.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "impedraw/run/log_row.h"
#include "impedraw/run/loop_sources.h"
#include "impedraw/terminal/clock.h"

namespace impedraw {
namespace {

void count_status(const ControlStatus& status, double dt, std::map<std::string, double>* met) {
  if (status.ok()) return;
  const std::pair<const char*, bool> all[] = {
      {"bad_input", status.bad_input},           {"stale_state", status.stale_state},
      {"stale_wrench", status.stale_wrench},     {"near_singular", status.near_singular},
      {"torque_limited", status.torque_limited}, {"speed_limited", status.speed_limited},
      {"joint_limit", status.joint_limit},       {"surface_lost", status.surface_lost},
      {"damping_limit", status.damping_limit},   {"stiff_contact", status.stiff_contact}};
  for (const auto& [name, set] : all)
    if (set) (*met)[name] += dt;
}

void note_slow_velocity(const JointStateEstimator& estimator, double asked,
                        std::optional<SlowVelocity>* slowest) noexcept {
  const double bandwidth = estimator.bandwidth();
  if (bandwidth >= (*slowest ? (*slowest)->bandwidth : asked)) return;
  int joint = 0;
  const double noise = estimator.noise().maxCoeff(&joint);
  *slowest = SlowVelocity{bandwidth, noise, joint};
}

// The mean place of the planned lines [m].
Eigen::Vector3d middle_of(const TipPath& path) {
  constexpr double kStep = 0.02;  // [s]
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double length = 0.0;
  for (const StrokeTimes& stroke : path.strokes())
    for (double t = stroke.start; t < stroke.end; t += kStep) {
      const Eigen::Vector3d from = path.at(t).reference.p_WD,
                            to = path.at(std::min(t + kStep, stroke.end)).reference.p_WD;
      sum += (to - from).norm() * (from + to) / 2.0;
      length += (to - from).norm();
    }
  return length > 0.0 ? Eigen::Vector3d(sum / length) : sum;
}

// The ink lies where it should, as far as the arm knows.
bool in_place(const Experiment& e, const Cycle& cycle) {
  constexpr double kInPlace = 2.5e-3;  // [m]
  return !e.belief.perception || cycle.behind().norm() < std::max(kInPlace, face_reach(e));
}

bool knows(const CanvasFollower& canvas) {
  const CanvasStatus status = canvas.estimate().status;
  return status == CanvasStatus::ok || status == CanvasStatus::undetermined;
}

}  // namespace

DrivenArm::DrivenArm(const Experiment& e, Driver& driver, const std::filesystem::path& log_file,
                     const RunHooks& hooks, const Resumption* resumption)
    : e_(e),
      driver_(driver),
      arm_(e.belief.arm),
      hooks_(hooks),
      waits_(driver.info().waits),
      first_time_(resumption ? resumption->time : 0.0),
      watch_(canvas_watch(e, driver, resumption ? resumption->X_WK : Pose())),
      loop_(e.control, e.belief.arm, driver.info(),
            surface_source(e, disturbances_of(e, resumption != nullptr),
                           watch_ ? watch_->surface() : nullptr),
            canvas_source(e, watch_.get(), driver)),
      last_(driver.info().period, e.belief.arm),
      real_time_(!waits_ && e.scenario.arm.real_time),
      started_(driver),
      state_(&driver.read()),
      row_(e.belief.arm.joints()),
      history_(middle_of(e.plan.path)) {
  out_.tau = JointVector::Zero(e.belief.arm.joints());
  out_.terms.setZero(e.belief.arm.joints(), kTorqueTerms);
  record_.not_real_time = real_time_.lacks();
  if (resumption) {
    ink_ = resumption->ink;
    for (const Resumption::Score& at : resumption->scores) loop_.scored(at.p_WE, at.n_W, at.f_n);
  }
  if (!log_file.empty() && resumption)
    log_.emplace(RunLog::append_to(log_file, make_header(e)));
  else if (!log_file.empty())
    log_.emplace(log_file, make_header(e));
  if (watch_) watch_->begin();
}

DrivenArm::~DrivenArm() {
  if (watch_) watch_->end();
}

Cycle DrivenArm::step(const PathSample& desired, const Law& law, double time_scale) {
  while (waits_ && hooks_.held && hooks_.held(time())) {
  }
  if (watch_) watch_->update(time(), state_->q);
  Cycle cycle{.time = time(),
              .run_time = run_time(),
              .dt = e_.control.impedance.timing.dt,
              .step_time = state_->step_time,
              .state_age = time() - state_->state_time,
              .desired = desired,
              .arm = loop_.terms(),
              .F_ext = loop_.F_ext(),
              .surface = loop_.surface(),
              .canvas = loop_.canvas(),
              .out = out_,
              .state = state_,
              .truth = driver_.truth(),
              .tool = name_of_tool(e_.scenario)};
  const auto step_start = Clock::now();
  if (law.kind == Law::Kind::damp)
    damped_end_.damp(loop_.terms().M, law.v, e_.belief.arm.limits().torque, cycle.dt, &out_);
  else if (!state_->stalled)
    out_ = law.kind == Law::Kind::brake ? loop_.brake(*state_, law.v_WD)
                                        : loop_.step(*state_, desired.reference);
  cycle.space = loop_.space();
  if (watch_) {
    watch_->feel(touch(cycle), cycle.time);
    record_.stamp_lag = watch_->felt().stamps().lag();
    cycle.confirmed = watch_->felt().share(FeltMotion::along_normal);
  }
  row_.step_time = seconds_since(step_start);
  row_.time_scale = time_scale;
  fill_state(e_, cycle, &row_);
  driver_.command(out_.tau, out_.terms.col(kGravity));
  keep(&cycle);
  cycle.tared = loop_.tared();
  cycle.state = state_ = &driver_.read();
  return cycle;
}

void DrivenArm::hold_pen(const HeldPen& pen) {
  const bool new_one = pen.number != pen_.number;
  const double longer_by = pen.longer - pen_.longer;
  arm_.lengthen_pen(longer_by);
  loop_.change_pen(longer_by, pen.radius, new_one);
  if (new_one) driver_.put_in(pen.number);
  pen_ = pen;
  if (hooks_.holds_pen) hooks_.holds_pen(pen);
}

// The contact by which the pen feels the canvas's motion.
PenTouch DrivenArm::touch(const Cycle& cycle) const {
  const bool touches =
      out_.mode == ContactMode::contact && e_.control.impedance.wrench == WrenchFeedback::measured;
  return {touches,
          cycle.arm.X_WE.p,
          cycle.arm.V_WE.head<3>(),
          out_.n_WD,
          cycle.F_ext.head<3>(),
          cycle.canvas.pose(),
          cycle.surface.status == SurfaceStatus::ok ? cycle.surface.distance : std::nan("")};
}

// Logs the cycle, and learns from it where the canvas is and what has ink.
void DrivenArm::keep(Cycle* cycle) {
  constexpr double kSettled = 1.0;  // the first estimates are not yet of the canvas's motion [s]
  fill_contact(e_, *cycle, &row_);
  if (log_) log_->append(row_);
  if (hooks_.row) hooks_.row(row_);
  count_status(out_.status, cycle->dt, &record_.met);
  if (const JointStateEstimator* const estimator = loop_.joint_estimator())
    note_slow_velocity(*estimator, e_.control.joint_estimator->bandwidth, &record_.slow_velocity);
  last_.add(row_, *cycle);
  if (cycle->canvas.follows() && knows(cycle->canvas)) {
    known_for_ += cycle->dt;
    if (known_for_ > kSettled) history_.add(cycle->time, cycle->canvas.pose());
  }
  cycle->inked = writes(e_, out_.mode, cycle->normal_force(), out_.push) && in_place(e_, *cycle);
  ink_.add(cycle->desired.stroke, cycle->desired.along, cycle->inked);
}

const LoopRecord& DrivenArm::finish() {
  if (watch_) {
    watch_->end();
    record_.frames = watch_->remark();
    if (!knows(loop_.canvas())) record_.silence = watch_->silence(time(), first_time_);
  }
  return record_;
}

void DrivenArm::end_at_zero() {
  const JointVector gravity = out_.terms.col(kGravity);
  driver_.command(gravity, gravity);
  state_ = &driver_.read();
}

WallTimes DrivenArm::close_log(const WallTimes& wall, const Ending& ending) {
  return log_ ? log_->close(wall, ending_text(ending)) : wall;
}

}  // namespace impedraw

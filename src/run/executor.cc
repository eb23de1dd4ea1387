#include "impedraw/run/executor.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/common/rotations.h"

namespace impedraw {
namespace {

constexpr double kLiftOffCanvas = 0.1;  // clear of a canvas that moves [m]
constexpr double kLetGo = 0.1;          // a canvas beyond the reach: within so long [s]
constexpr double kLiftALittle = 0.01;   // at a blocked place [m]
constexpr long kPollEvery = 10;         // cycles
constexpr double kBump = 10.0;          // on a pen that is changed or checked, in the air [N]

PathSample in_air(const TipReference& reference, Phase phase) {
  return {reference, -1, std::nan(""), phase};
}

bool feels(const Experiment& e) { return e.control.impedance.wrench == WrenchFeedback::measured; }

}  // namespace

Executor::Executor(const Experiment& e, DrivenArm& arm, const RunHooks& hooks)
    : e_(e),
      arm_(arm),
      hooks_(hooks),
      reaction_(&ending_),
      monitors_(e, arm.driver(), hooks),
      block_(e),
      reach_(e.scenario.preflight.arm, e.belief.arm.limits().speed),
      canvas_(e.scenario.perception.frames.wait_for_rest),
      chance_(e.belief.perception && touches(e.scenario)) {
  const Pose X_WE = arm.X_WE();
  rest_.p_WD = X_WE.p;
  rest_.n_WD = -X_WE.R.col(2);
}

Situation Executor::situation() const {
  const CanvasFollower& canvas = arm_.loop().canvas();
  return {.pen = {arm_.time(), arm_.X_WE(), canvas.pose(), arm_.state().q, canvas.joined()},
          .canvas = canvas.estimate().status,
          .belief = arm_.belief(),
          .history = arm_.history(),
          .ink = arm_.ink(),
          .last = last_};
}

void Executor::carry_out(const Move& move) {
  last_ = {};
  reaction_.begin();
  const CanvasFollower& canvas = arm_.loop().canvas();
  if (move.pen) {
    rest_.p_WD -= (move.pen->longer - arm_.pen().longer) * rest_.n_WD;
    arm_.hold_pen(*move.pen);
  }
  switch (move.kind) {
    case Move::Kind::draw:
      if (canvas.follows() && !canvas.joined()) arm_.loop().join_canvas(rest_, move.join);
      return draw(move);
    case Move::Kind::lift:
      return lift();
    case Move::Kind::wait:
      return rest_while([&] { return arm_.time() < move.until; }, move.waits_for);
    case Move::Kind::ask:
      if (hooks_.pause) hooks_.pause(move.asks);
      return rest_while([&] { return arm_.time() <= move.until || paused(); }, "a person");
    case Move::Kind::feel:
      return feel(move.depth);
    case Move::Kind::go_to:
      return go_to(move);
    case Move::Kind::end:
      if (move.cause.empty()) return;
      if (canvas.joined()) lift();
      return reaction_.take({Severity::lift, move.cause});
  }
}

void Executor::draw(const Move& move) {
  PathFollower path(e_, arm_, move);
  block_.begin_path();
  canvas_.begin_path();
  const auto holds = [&] { return move.holds(situation(), move.path, path.planned()); };
  for (long i = 0; path.goes_on(i) || reaction_.state() != Reaction::State::follow; ++i) {
    if (lifted()) {
      end_lift();
      break;
    }
    rate_ = path.rate();
    std::optional<PathSample> desired = path.sample(lift_.has_value(), holds);
    if (!desired) break;
    if (lift_) desired = in_air(lift_->at(arm_.time()), Phase::lift);
    if (!lift_ && path.comes_to_pause() && hooks_.pause)
      hooks_.pause("the drawing waits before a layer");
    const std::optional<Cycle> cycle = step(*desired);
    if (!cycle) break;
    if (!reaction_.cause().empty() && !last_.blocked)
      last_.blocked = place_on_path(*desired, move.path, path.planned(), true);
    if (!lift_ && !follow_up(*cycle, move, &path)) break;
    if (i % kPollEvery == 0) poll(*cycle, path);
  }
  if (!arm_.loop().canvas().follows()) {
    const Pose X_WE = arm_.X_WE();
    rest_ = TipReference();
    rest_.p_WD = X_WE.p;
    rest_.n_WD = -X_WE.R.col(2);
  }
  rate_ = path.rate();
  last_.strokes_followed = path.strokes_followed();
  last_.lost_canvas = canvas_.let_go();
}

void Executor::go_to(const Move& move) {
  const double begin = arm_.time(), duration = move.until - begin;
  const TipReference from = rest_;
  const Eigen::Vector3d way = move.place_W - from.p_WD;
  const Eigen::AngleAxisd turn(turn_between(from.n_WD, move.normal_W.value_or(from.n_WD)));
  const auto goes_on = [&] {
    if (move.normal_W && !lift_ && arm_.loop().F_ext().head<3>().norm() > kBump)
      react({Severity::lift, fmt::format("the pen met something in the air at t = {:.3f} s, on its "
                                         "way to or from pen.place and pen.spot",
                                         arm_.run_time())});
    return arm_.time() < move.until;
  };
  move_in_world(goes_on, nullptr, [&](double time) {
    const MinimumJerk jerk =
        MinimumJerk::at(std::clamp((time - begin) / duration, 0.0, 1.0), duration);
    TipReference on_way = from;
    on_way.p_WD += jerk.share * way;
    on_way.v_WD = jerk.rate * way;
    on_way.a_WD = jerk.change * way;
    on_way.n_WD = Eigen::AngleAxisd(jerk.share * turn.angle(), turn.axis()) * from.n_WD;
    on_way.w_WD = jerk.rate * turn.angle() * turn.axis();
    on_way.alpha_WD = jerk.change * turn.angle() * turn.axis();
    return on_way;
  });
  if (!this->goes_on()) return;
  rest_.p_WD = move.place_W;
  rest_.n_WD = turn * from.n_WD;
}

// The force is held for a while once it is felt, and the tip's place is the mean over its end.
void Executor::feel(double depth) {
  constexpr double kSpeed = 5e-3;   // [m/s]
  constexpr double kForce = 1.0;    // [N]
  constexpr double kFilter = 0.02;  // of the force [s]
  constexpr double kPress = 0.6;    // [s]
  const double dt = e_.control.impedance.timing.dt;
  const Eigen::Vector3d n = rest_.n_WD;
  TipReference down = rest_;
  double way = 0.0, force = 0.0, pressed = 0.0, count = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  move_in_world([&] { return pressed < kPress && way < depth; }, nullptr,
                [&](double) {
                  force += dt / (kFilter + dt) * (n.dot(arm_.loop().F_ext().head<3>()) - force);
                  const bool presses = pressed > 0.0 || force >= kForce;
                  if (presses) pressed += dt;
                  if (pressed > 0.5 * kPress) {
                    sum += arm_.X_WE().p;
                    count += 1.0;
                  }
                  if (!presses) way += kSpeed * dt;
                  down.p_WD = rest_.p_WD - way * n;
                  down.v_WD = presses ? Eigen::Vector3d::Zero() : Eigen::Vector3d(-kSpeed * n);
                  return down;
                });
  if (!goes_on()) return;
  rest_.p_WD = down.p_WD;
  if (pressed >= kPress) last_.felt = sum / count;
}

void Executor::rest_while(const std::function<bool()>& goes_on, const char* waits_for) {
  move_in_world(goes_on, waits_for, [this](double) { return rest_; });
}

void Executor::move_in_world(const std::function<bool()>& goes_on, const char* waits_for,
                             const std::function<TipReference(double)>& motion) {
  const double begin = arm_.time();
  while (reaction_.state() != Reaction::State::follow || goes_on()) {
    if (lifted()) return end_lift();
    const double time = arm_.time();
    const PathSample desired =
        lift_ ? in_air(lift_->at(time), Phase::lift) : in_air(motion(time), Phase::travel);
    if (!step(desired)) return;
    if (waits_for) tell_wait(waits_for, arm_.time() - begin);
    if (!lift_ && interrupted())
      return reaction_.take({Severity::lift,
                             fmt::format("interrupted at t = {:.3f} s", arm_.run_time()),
                             RunEnd::interrupted});
  }
}

void Executor::lift() {
  const Pose X_WE = arm_.X_WE();
  if (arm_.loop().canvas().follows())
    lift_off_canvas(clear_height());
  else
    lift_.emplace(arm_.time(), X_WE, -X_WE.R.col(2));
  monitors_.tare().moves_first(lift_->duration());
  reaction_.take({Severity::lift, {}, RunEnd::finished});
  move_in_world([] { return false; }, nullptr, {});
}

std::optional<Cycle> Executor::step(const PathSample& desired) {
  const Reaction::State before = reaction_.state();
  const Cycle cycle = arm_.step(desired, law(desired), rate_);
  chance_.update(cycle);
  Verdict verdict = monitors_.judge(cycle, reaction_, last_.blocked.has_value());
  if (verdict.severity == Severity::lift && verdict.end == RunEnd::finished) {
    unseen_ = true;
    verdict = {};
  }
  if (verdict.severity == Severity::brake && !(goes_on() && chance_.given()))
    verdict.end = RunEnd::stopped;
  react(verdict);
  // A canvas that is left carries the pen along for a while: not to where the arm cannot follow.
  if (lift_ && cycle.canvas.leaves() && reach_.loses(cycle)) begin_lift(Verdict::Rise::let_go);
  settle(cycle, before);
  if (reaction_.state() == Reaction::State::over) return std::nullopt;
  return cycle;
}

// Chooses the law of the next torque: a motion that is out of control is damped, but not by a stale
// state, which would drive it: the control law then only holds the arm's weight.
Law Executor::law(const PathSample& desired) const {
  const ArmState& read = arm_.state();
  if (!(read.time - read.state_time <= e_.control.impedance.timing.max_state_age)) return {};
  if (reaction_.state() == Reaction::State::damp)
    return {.kind = Law::Kind::damp, .v = monitors_.confirmed_speed(arm_.state())};
  if (!reaction_.lost_control()) return {};
  Law brake{.kind = Law::Kind::brake};
  if (!reaction_.brakes()) brake.v_WD = arm_.loop().canvas().pose().R * desired.reference.v_WD;
  return brake;
}

void Executor::react(const Verdict& verdict) {
  reaction_.take(verdict);
  if (reaction_.state() == Reaction::State::lift && !lift_)
    begin_lift(verdict.rise, verdict.aside_W);
}

// The end of what is damped. The simulated arm only ends where it is: it is damped first. Another
// driver damps in stop(), by its own session.
void Executor::settle(const Cycle& cycle, Reaction::State before) {
  using State = Reaction::State;
  const State now = reaction_.state();
  if ((now == State::halt || now == State::damp) && !cycle.truth) return reaction_.end();
  if (now == State::damp) {
    if (before != State::damp || !arm_.damped_end().over(monitors_.confirmed_speed(*cycle.state)))
      return;
    reaction_.end();
    return arm_.end_at_zero();
  }
  if (now != State::halt && !(now == State::brake && before == State::brake)) return;
  if (!reaction_.calms(cycle.speed_share(e_.belief.arm.limits().speed), cycle.dt)) return;
  if (reaction_.state() == State::over)
    arm_.end_at_zero();
  else if (!lift_)
    begin_lift(Verdict::Rise::clear);
}

bool Executor::follow_up(const Cycle& cycle, const Move& move, PathFollower* path) {
  const bool is_paused = paused();
  if (path->by_touch()) return path->advance_by_touch(cycle, arm_.loop(), is_paused);
  const bool held = canvas_.hold(cycle).severity == Severity::hold;
  path->advance(cycle, is_paused || held);

  std::optional<StrokePart> place;
  const Verdict canvas = canvas_.judge(cycle, is_paused);
  if (held && !is_paused) tell_wait(canvas_.waits_for(cycle), canvas_.waited());
  const Verdict blocked =
      block_.judge(cycle, move.path, path->planned(), std::exchange(unseen_, false), &place);
  const Verdict reach = reach_.judge(cycle);
  const Verdict& worst = worse(canvas, worse(blocked, reach));
  if (&worst == &blocked) last_.blocked = place;
  last_.left_reach = &worst == &reach && reach.end == RunEnd::finished;
  if (worst.severity < Severity::lift && path->passes_last_stroke(cycle) && move.complete &&
      move.complete(arm_.ink())) {
    lift_off_canvas(clear_height());
    reaction_.take({Severity::lift, {}, RunEnd::finished});
    return true;
  }
  react(worst);
  return worst.severity != Severity::leave;
}

void Executor::poll(const Cycle& cycle, const PathFollower& path) {
  if (!lift_ && interrupted())
    react(
        {Severity::lift,
         fmt::format("interrupted at t = {:.3f} s; the {} was lifted", cycle.run_time, cycle.tool),
         RunEnd::interrupted});
  if (hooks_.progress && !canvas_.waits_for(cycle)) hooks_.progress(path.progress(cycle.run_time));
}

void Executor::begin_lift(Verdict::Rise rise, const Eigen::Vector3d& aside_W) {
  if (rise == Verdict::Rise::let_go) return lift_off_canvas(kLiftOffCanvas, kLetGo);
  const Eigen::Matrix3d R_KW = arm_.loop().canvas().pose().R.transpose();
  lift_.emplace(arm_.time(), arm_.X_KE(), R_KW * arm_.out().n_WD,
                rise == Verdict::Rise::a_little ? kLiftALittle : EmergencyLift::kHeight,
                R_KW * aside_W);
}

// The pen goes up in W. A canvas that heaves does not catch up with it.
void Executor::lift_off_canvas(double height, std::optional<double> within) {
  const Eigen::Vector3d& up = e_.control.impedance.surface.drawing_axis_W;
  lift_.emplace(arm_.time(), arm_.X_WE(), up, height);
  arm_.loop().leave_canvas(within.value_or(lift_->duration()), up);
}

// Up to where the run began, as far as the arm reaches [m].
double Executor::clear_height() const {
  ArmModel arm = e_.belief.arm;
  const Pose X_WE = arm_.X_WE();
  const JointVector& q = arm_.state().q;
  const Eigen::Vector3d& up = e_.control.impedance.surface.drawing_axis_W;
  double height = std::max(kLiftOffCanvas, up.dot(e_.scenario.arm.start_p_WE - X_WE.p));
  while (height > kLiftOffCanvas &&
         !find_posture(arm, {X_WE.p + height * up, X_WE.R.col(2)}, q).reached)
    height -= 0.02;
  return height;
}

// The arm of a run that was stopped still moves: a hand may have let go of it just now. Waits for
// rest, but not for ever.
bool Executor::lifted() const {
  constexpr double kAtRest = 0.5;   // speed of the fastest joint [rad/s]
  constexpr double kLongest = 2.0;  // [s]
  const double time = arm_.time();
  if (!lift_ || !lift_->done(time)) return false;
  if (reaction_.state() == Reaction::State::lift) return true;
  return reaction_.state() == Reaction::State::rise &&
         (arm_.loop().terms().v.cwiseAbs().maxCoeff() <= kAtRest || lift_->done(time - kLongest));
}

void Executor::end_lift() {
  std::string& goes_on_after = reaction_.cause();
  if (reaction_.state() == Reaction::State::rise) {
    const double risen = lift_->risen(arm_.X_KE().p);
    std::string& cause = goes_on_after.empty() ? ending_.cause : goes_on_after;
    cause += fmt::format("; the motion was damped and the {} ", name_of_tool(e_.scenario));
    cause += risen < 1e-3 ? "did not rise" : fmt::format("lifted by {:.0f} mm", 1e3 * risen);
  }
  if (!goes_on_after.empty()) {
    damped_.push_back(goes_on_after);
    chance_.take();
  }
  rest_ = lift_->at(arm_.time());
  lift_.reset();
  reaction_.done();
}

// In the rhythm of the other progress.
void Executor::tell_wait(const char* what, double waited) const {
  const double dt = e_.control.impedance.timing.dt;
  if (!hooks_.progress || std::fmod(waited, kPollEvery * dt) >= dt) return;
  hooks_.progress({arm_.run_time(), 0, 0, 0.0, 0.0, 0.0, false, what, waited});
}

ArmMonitors::ArmMonitors(const Experiment& e, const Driver& driver, const RunHooks& hooks)
    : driver_(driver),
      hooks_(hooks),
      tare_(e.plan.path_settings.start_hold, e.control.estimator.tare_time),
      reading_(driver.info(), e.belief.arm.limits().speed, e.belief.arm.limits().torque,
               e.scenario.arm.wrench_delay, feels(e)),
      signs_(e.control.impedance, e.belief.arm.limits().torque),
      fences_(e.scenario.fence, feels(e)),
      range_(has_sensor(e.control.source) ? e.control.estimator : WrenchEstimatorSettings()),
      speed_(e.belief.arm.limits().speed, e.belief.arm.joint_names()),
      rattle_(e.control.impedance.stability_check.contact_stiffness_max,
              e.belief.perception && feels(e)) {}

Verdict ArmMonitors::judge(const Cycle& cycle, const Reaction& reaction, bool blocked) {
  const Reaction::State state = reaction.state();
  Verdict worst = worse(state_.judge(cycle, driver_.fault()), tare_.judge(cycle));
  if (worst) return worst;
  worst = reading_.judge(cycle, reaction.lost_control());
  if (worst || state == Reaction::State::damp) return worst;
  if (cycle.out.status.stale_state) return emergency(cycle);  // foretold, it tells nothing
  worst = signs_.judge(cycle);
  if (!worst) worst = dead_wrench_.judge(cycle, signs_.held());
  worst = worse(worst, reversal_.judge(cycle));
  if (worst) return worst;
  if (state != Reaction::State::halt) worst = emergency(cycle);
  if (!worst) worst = fences_.judge(cycle);
  if (!worst) worst = range_.judge(cycle);
  if (!worst && !reaction.brakes()) worst = speed_.judge(cycle);
  const Verdict rattle = rattle_.judge(cycle);
  if (!blocked && !fences_.force_beyond()) worst = worse(worst, rattle);
  return worse(worst, step_time_.judge(cycle));
}

Verdict ArmMonitors::emergency(const Cycle& cycle) const {
  if (!hooks_.emergency || !hooks_.emergency()) return {};
  return {Severity::halt,
          fmt::format("emergency stop at t = {:.3f} s, by a person", cycle.run_time)};
}

}  // namespace impedraw

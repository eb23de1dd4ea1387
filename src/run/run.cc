#include "impedraw/run/run.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/minimum_jerk.h"
#include "impedraw/control/step_watchdog.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/preflight_of_plan.h"
#include "impedraw/run/canvas_watch.h"
#include "impedraw/run/control_loop.h"
#include "impedraw/run/damped_end.h"
#include "impedraw/run/disturbances.h"
#include "impedraw/run/emergency_lift.h"
#include "impedraw/run/fences.h"
#include "impedraw/run/incident.h"
#include "impedraw/run/joint_forecast.h"
#include "impedraw/run/log_row.h"
#include "impedraw/run/odometer.h"
#include "impedraw/run/plan_clock.h"
#include "impedraw/run/plan_wait.h"
#include "impedraw/run/rattle_guard.h"
#include "impedraw/run/reading_check.h"
#include "impedraw/run/real_time.h"
#include "impedraw/run/rest_watch.h"
#include "impedraw/run/simulated_arm.h"
#include "impedraw/run/speed_guard.h"
#include "impedraw/run/touched_heights.h"
#include "impedraw/run/wall_watch.h"
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
      {"damping_limit", status.damping_limit}};
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

// A resumed run has none: they occurred in the first run.
Disturbances disturbances_of(const Experiment& e, const Resumption* resumption) {
  return resumption ? Disturbances() : Disturbances(e.scenario, e.plan.path);
}

// growing: null where the surface stays as the snapshot saw it.
SurfaceSource surface_source(const Experiment& e, Disturbances disturbances,
                             const GrowingSurface* growing) {
  if (!e.scene.perception) return {};
  return [&cloud = *e.scene.perception, growing, disturbances = std::move(disturbances)](
             const Eigen::Vector3d& p_W, double time) {
    SurfaceEstimate surface = growing ? growing->estimate(p_W) : cloud.estimate(p_W);
    if (disturbances.fault(FaultKind::no_cloud, time)) surface.status = SurfaceStatus::too_few;
    return surface;
  };
}

// Of the true motion, to judge the controller alone. Accelerations by central differences.
CanvasEstimate true_canvas(const CanvasMotion& motion, double time) {
  constexpr double kStep = 1e-4;  // [s]
  const auto origin_of = [&](double t, Eigen::Vector3d* v) {
    const CanvasMotion::State state = motion.at(t);
    *v = state.velocity_at(state.X_WK.p);
    return state;
  };
  Eigen::Vector3d v, before, after;
  const CanvasMotion::State now = origin_of(time, &v), earlier = origin_of(time - kStep, &before),
                            later = origin_of(time + kStep, &after);
  CanvasEstimate estimate;
  estimate.status = CanvasStatus::ok;
  estimate.motion = {now.X_WK, v, (after - before) / (2.0 * kStep), now.w,
                     (later.w - earlier.w) / (2.0 * kStep)};
  return estimate;
}

bool follows_canvas(const Experiment& e) {
  const PerceptionSettings& p = e.scenario.perception;
  if (!e.scene.perception) return false;
  return p.canvas_pose == CanvasPoseSource::tracked ? p.frames.enabled
                                                    : e.scene.world->canvas_motion().moves();
}

// Cameras keep capturing, and find where the canvas is.
std::unique_ptr<CanvasTracker> canvas_tracker(const Experiment& e, const Resumption* resumption) {
  const PerceptionSettings& p = e.scenario.perception;
  if (!follows_canvas(e) || p.canvas_pose != CanvasPoseSource::tracked) return nullptr;
  std::unique_ptr<CanvasShape> shape;
  if (p.frames.depth) {
    CanvasShapeSettings settings;
    settings.points.sigma_at_1m = std::max(p.noise.sigma_at_1m, 1e-4);
    settings.self_padding = p.self_padding;
    shape = std::make_unique<CanvasShape>(e.scene.perception->cloud(), settings);
  }
  return std::make_unique<CanvasTracker>(
      CanvasTrackerSettings{.fiducials = p.fiducials,
                            .prediction = p.frames.prediction,
                            .X_WK = resumption ? resumption->X_WK : Pose()},
      std::move(shape));
}

// Null where no camera keeps capturing.
std::unique_ptr<CanvasWatch> canvas_watch(const Experiment& e, Driver& driver,
                                          const Resumption* resumption) {
  const PerceptionSettings& p = e.scenario.perception;
  std::unique_ptr<CanvasTracker> tracker = canvas_tracker(e, resumption);
  if (!tracker) return nullptr;
  const bool lock_step = driver.info().waits;
  std::unique_ptr<GrowingSurface> surface;
  if (tracker->shape() && p.frames.grow_surface)
    surface = std::make_unique<GrowingSurface>(*e.scene.perception, p.normals, lock_step);
  return std::make_unique<CanvasWatch>(std::move(tracker), std::move(surface), driver,
                                       p.frames.stamp_error, lock_step);
}

// first_time: of the run [s].
CanvasSource canvas_source(const Experiment& e, CanvasWatch* watch, double first_time) {
  if (watch)
    return [watch, feeds = e.scenario.perception.frames.feedforward](double time) {
      CanvasEstimate estimate = watch->follow(time);
      if (!feeds) estimate.motion = {.X_WK = estimate.motion.X_WK};
      return estimate;
    };
  const CanvasMotion& motion = e.scene.world->canvas_motion();
  if (follows_canvas(e))
    return [&motion, first_time](double time) { return true_canvas(motion, first_time + time); };
  return {};
}

Eigen::Vector3d middle_of(const TargetLine& target) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : target.points) sum += p;
  return target.points.empty() ? sum
                               : Eigen::Vector3d(sum / static_cast<double>(target.points.size()));
}

// An approach may take so long to find a surface [s].
double longest_search(const Experiment& e) {
  const ApproachSettings& approach = e.control.impedance.approach;
  return approach.overtravel / approach.speed + 2.0;
}

ClockSettings clock_settings(const Experiment& e) {
  ClockSettings settings;
  if (e.scene.by_touch()) settings.patience = 2.0 * longest_search(e);
  return settings;
}

// What a plan waits for on a canvas that moves.
constexpr const char *kToBeSeen = "the cameras to know the canvas again",
                     *kToRest = "the canvas to rest";

class Runner {
 public:
  Runner(Experiment& e, Driver& driver, const std::filesystem::path& log_file,
         const RunHooks& hooks, const Resumption* resumption)
      : e_(e),
        driver_(driver),
        hooks_(hooks),
        waits_(driver.info().waits),
        first_time_(resumption ? resumption->time : 0.0),
        watch_(canvas_watch(e, driver, resumption)),
        loop_(
            e.control, e.scene.arm, driver.info(),
            surface_source(e, disturbances_of(e, resumption), watch_ ? watch_->surface() : nullptr),
            canvas_source(e, watch_.get(), first_time_)),
        fences_(e.scenario.fence, e.control.impedance.wrench == WrenchFeedback::measured),
        reading_(driver.info(), e.scene.arm.limits().speed, e.scene.arm.limits().torque,
                 e.scenario.arm.wrench_delay),
        last_(driver.info().period, e.scene.arm),
        real_time_(!waits_ && e.scenario.arm.real_time),
        started_(driver),
        state_(&driver.read()),
        clock_(clock_settings(e), e.control.impedance.timing.dt),
        guard_(e.scene.arm.limits().speed),
        heights_(e.scenario.blind.top_z),
        row_(e.scene.arm.joints()),
        history_(middle_of(e.plan.target)) {
    out_.tau = JointVector::Zero(e.scene.arm.joints());
    out_.terms.setZero(e.scene.arm.joints(), kTorqueTerms);
    outcome_.not_real_time = real_time_.lacks();
    if (resumption) ink_ = resumption->ink;
    if (!log_file.empty() && resumption)
      log_.emplace(RunLog::append_to(log_file, make_header(e)));
    else if (!log_file.empty())
      log_.emplace(log_file, make_header(e));
    if (watch_) watch_->begin();
  }

  ~Runner() {
    if (watch_) watch_->end();
  }
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;

  // Follows the path from its beginning to its end, or until something stops the run.
  void follow(const TipPath& path, bool again) { follow(path, again, nullptr); }

  void end(const std::string& cause) { stop(RunEnd::stopped, cause); }

  bool lost_canvas() const { return lost_canvas_; }
  bool canvas_moves() const { return loop_.canvas().follows(); }

  // The arm rests while the cameras watch the canvas.
  void watch() {
    const Pose X_WE = e_.scene.arm.tip_pose(state_->q);
    rest_.p_WD = X_WE.p;
    rest_.n_WD = -X_WE.R.col(2);
    if (first_time_ > 0.0) {  // an earlier run may have left the pen on the canvas
      lift_off_canvas();
      raised_for_ = lifting_->duration();
      retire();
    }
    wait(time() + e_.scenario.perception.watch, "the cameras to watch the canvas");
    if (outcome_.end != RunEnd::finished) return;
    if (loop_.canvas().estimate().status == CanvasStatus::lost)
      return stop(RunEnd::stopped,
                  fmt::format("no camera saw three marks of the canvas within {:.3g} s; "
                              "perception.fiducials.points and perception.cameras tell where they "
                              "should be",
                              e_.scenario.perception.watch));
    if (watch_) outcome_.canvas_open = watch_->belief().open_text();
  }

  // Stays at rest in W, where retire() left the pen.
  void wait(double until, const char* what) {
    const PathSample rest{rest_, -1, std::nan(""), Phase::travel};
    const double begin = time();
    while (time() < until) {
      if (!step(rest)) return;
      tell_wait(what, time() - begin);
      if (hooks_.interrupted && hooks_.interrupted())
        return stop(RunEnd::interrupted,
                    fmt::format("interrupted at t = {:.3f} s", first_time_ + time()));
    }
  }

  // Goes there in W, from rest to rest, until then; the pen stays as it is turned.
  void go_to(const Eigen::Vector3d& p_W, double until) {
    const Eigen::Vector3d from = rest_.p_WD;
    const double begin = time(), duration = until - begin;
    while (time() < until) {
      const MinimumJerk jerk = MinimumJerk::at((time() - begin) / duration, duration);
      PathSample on_way{rest_, -1, std::nan(""), Phase::travel};
      on_way.reference.p_WD = from + jerk.share * (p_W - from);
      on_way.reference.v_WD = jerk.rate * (p_W - from);
      on_way.reference.a_WD = jerk.change * (p_W - from);
      if (!step(on_way)) return;
    }
    rest_.p_WD = p_W;
    rest_.v_WD = rest_.a_WD = Eigen::Vector3d::Zero();
  }

  // The pen goes up in W, clear of the canvas wherever that goes, and rests there.
  void retire() {
    if (!lifting_) lift_off_canvas();
    while (!lifting_->done(time()))
      if (!step({lifting_->at(time()), -1, std::nan(""), Phase::lift})) return;
    rest_ = lifting_->at(time());
    lifting_.reset();
  }

  // A pen at rest moves with the canvas from now on.
  void join(double duration) { loop_.join_canvas(rest_, duration); }
  bool joined() const { return loop_.canvas().joined(); }

  CanvasForecast forecast() const {
    return e_.scenario.perception.frames.wait_for_rest
               ? CanvasForecast::standing(loop_.canvas().pose())
               : history_.forecast();
  }
  CarriedPen pen() const {
    return {time(), e_.scene.arm.tip_pose(state_->q), loop_.canvas().pose(), state_->q, joined()};
  }
  bool knows_canvas() const {
    const CanvasStatus status = loop_.canvas().estimate().status;
    return status == CanvasStatus::ok || status == CanvasStatus::undetermined;
  }
  // During the last path, in contact or on the way.
  bool left_reach() const { return left_reach_; }
  // Of the last path, those that the plan went along to their end.
  std::size_t strokes_followed() const { return followed_; }
  // Asked between the strokes of a path, with the plan's time: false ends it there.
  using Between = std::function<bool(const TipPath& path, double planned)>;
  void follow(const TipPath& path, bool again, const Between& between) {
    between_ = &between;
    follow(path, again, nullptr);
    between_ = nullptr;
  }

  // The tip in the canvas's frame.
  Pose X_KE() const { return loop_.canvas().pose().inverse() * e_.scene.arm.tip_pose(state_->q); }

  // Draws on a surface that is found by touch, stroke by stroke. Each way is planned from where the
  // pen is and from the heights touched so far, and its clock waits for touch.
  void feel(const std::vector<PlacedStroke>& strokes, double hold, bool again) {
    for (std::size_t i = 0; i < strokes.size() && outcome_.end == RunEnd::finished; ++i) {
      const Pose X_WE = e_.scene.arm.tip_pose(state_->q);
      const Eigen::Vector2d first = strokes[i].p_P.front();
      const StrokeCount count{static_cast<int>(i), static_cast<int>(strokes.size())};
      follow(plan_from(e_.plan.path_settings, level_surface(heights_.level(first.x(), first.y())),
                       {strokes[i]}, X_WE.p, -X_WE.R.col(2), i == 0 ? hold : 0.0),
             again, &count);
    }
    const Pose X_WE = e_.scene.arm.tip_pose(state_->q);
    const EmergencyLift up(time(), X_WE, -X_WE.R.col(2));
    while (outcome_.end == RunEnd::finished && !up.done(time()))
      if (!step({up.at(time()), -1, std::nan(""), Phase::lift})) return;
  }

  // The place of a wall before which the last path was given up; nothing: it was followed to its
  // end.
  const std::optional<StrokePart>& wall() const { return wall_; }
  const JointVector& q() const { return state_->q; }

  double time() const { return state_->time; }
  RunOutcome& outcome() { return outcome_; }
  WallTimes close_log(const WallTimes& wall) {
    return log_ ? log_->close(wall, ending_text(outcome_)) : wall;
  }
  const InkWatch& ink() const { return ink_; }
  void keep_last() {
    if (outcome_.end == RunEnd::stopped) outcome_.last = last_.rows();
  }

 private:
  struct StrokeCount {
    int before, all;
  };

  // `one`: the path is of one stroke among several. It then ends when the pen is to be lifted.
  void follow(const TipPath& path, bool again, const StrokeCount* one) {
    const double begin = time();
    const Odometer odometer(path);
    bool down = false, last_up = false;
    height_ = searched_ = 0.0;
    wall_.reset();
    lost_canvas_ = left_reach_ = false;
    followed_ = 0;
    Phase last_phase = Phase::travel;
    wall_watch_.reset();
    side_watch_.reset();
    sink_watch_.reset();
    clock_.restart();
    forecast_ = {};
    if (e_.scene.perception && !canvas_moves())
      forecast_ = JointForecast(e_.scene.arm, path, state_->q, e_.plan.rest_q,
                                e_.plan.path_settings.joint_speed_share);
    const auto steps = [&] {
      return std::lround(std::ceil((path.duration() + clock_.lag()) / dt()));
    };
    for (long i = 0; i < steps() || lifting_ || guard_.braking(); ++i) {
      const double t = time(), planned = t - begin - clock_.lag();
      if (lifting_ && lifting_->done(t) && !guard_.braking() && !swings(t)) {
        if (retreats_) {
          std::string& cause = damped_.empty() ? outcome_.cause : damped_;
          const double risen = lifting_->risen(X_KE().p);
          cause += "; the motion was damped and the pen ";
          cause += risen < 1e-3 ? "did not rise" : fmt::format("lifted by {:.0f} mm", 1e3 * risen);
        }
        rest_ = lifting_->at(t);
        if (wall_ || left_reach_ || !damped_.empty()) lifting_.reset();
        if (!damped_.empty()) {
          outcome_.damped.push_back(std::exchange(damped_, {}));
          drawn_ = 0.0;
          retreats_ = false;
        }
        return;
      }
      PathSample desired = path.at(planned);
      while (!lifting_ && followed_ < path.strokes().size() &&
             path.strokes()[followed_].end <= planned)
        ++followed_;
      if (between_ && !lifting_ && followed_ > 0 && last_phase == Phase::lift &&
          desired.phase == Phase::travel && !(*between_)(path, planned))
        return;
      last_phase = desired.phase;
      if (one && down && !desired.reference.pen_down && !lifting_) return;
      down = desired.reference.pen_down;
      if (one) desired.reference = at_touched_height(desired.reference);
      if (dry_run_) {
        desired.reference.p_WD += *dry_run_ * e_.control.impedance.surface.drawing_axis_W;
        desired.reference.pen_down = false;
      }
      desired.reference = clock_.scaled(desired.reference);
      if (lifting_) desired = {lifting_->at(t), -1, std::nan(""), Phase::lift};
      if (!step(desired)) return;
      if (!damped_.empty() && !wall_) wall_ = place_on_path(desired, path, planned, true);
      if (one && !lifting_ && !wait_for_touch(desired)) return;
      if (!one && !lifting_) {
        if (e_.scenario.perception.frames.wait_for_rest && loop_.canvas().joined())
          rest_watch_.update(loop_.canvas().estimate().motion, loop_.terms().X_WE.p, dt());
        clock_.advance(deviation(desired, planned));
        if (waits_too_long(desired)) continue;
        look_for_wall(desired, path, planned);
        look_for_reach();
        if (!last_up && off_a_moving_canvas() && planned > path.strokes().back().end) {
          last_up = true;
          std::vector<StrokePart> done = ink_.parts();
          for (const UnreachedPart& u : outcome_.unreached) done.push_back(u.part);
          if (rest_of(e_.plan.strokes, done, kShortestGap).empty()) lift_off_canvas();
        }
        if (found_again()) return;
      }
      if (i % 10 != 0) continue;
      if (!lifting_ && hooks_.interrupted && hooks_.interrupted()) {
        stop(RunEnd::interrupted,
             fmt::format("interrupted at t = {:.3f} s; the pen was lifted", first_time_ + t));
        lift();
      }
      if (!hooks_.progress || waits_for(desired)) continue;
      RunProgress progress{
          first_time_ + t, 0, 0, 0.0, 0.0, std::min(1.0, planned / path.duration()), again};
      odometer.read(planned, &progress);
      if (one) {
        progress.stroke += one->before;
        progress.strokes = one->all;
        progress.share = (one->before + progress.share) / one->all;
      }
      hooks_.progress(progress);
    }
  }

  // The plan's height is a guess: once the pen is down, it is where the tip is.
  TipReference at_touched_height(TipReference reference) {
    const Eigen::Vector3d& z = e_.control.impedance.surface.drawing_axis_W;
    const bool on_surface = out_.mode == ContactMode::approach || out_.mode == ContactMode::contact;
    if (reference.pen_down && on_surface) height_ = z.dot(loop_.terms().X_WE.p - reference.p_WD);
    reference.p_WD += height_ * z;
    return reference;
  }

  // Returns false if there is no surface where it may be: the stroke is given up.
  bool wait_for_touch(const PathSample& desired) {
    const bool contact = out_.mode == ContactMode::contact;
    const bool searching = desired.phase == Phase::approach && !contact;
    const Eigen::Vector3d p_PE = e_.artwork.X_WP.inverse() * loop_.terms().X_WE.p;
    if (contact) heights_.add(p_PE);
    searched_ = searching ? searched_ + dt() : 0.0;
    if (searched_ > longest_search(e_)) return false;
    if (out_.mode == ContactMode::approach && p_PE.z() < e_.scenario.blind.plane_z) return false;
    PenDeviation pen;
    pen.paused = paused();
    pen.waits = searching || (desired.stroke >= 0 && out_.mode == ContactMode::approach);
    if (contact && desired.stroke >= 0) pen.tilt = tilt_of_pen();
    clock_.advance(pen);
    return true;
  }

  // Between the pen and the normal that has been learned, to which it turns at its own speed [rad].
  double tilt_of_pen() const {
    const Eigen::Vector2d slope = loop_.touch()->slope();
    const Eigen::Vector3d n = loop_.touch()->axes() * Eigen::Vector3d(-slope.x(), -slope.y(), 1.0);
    return smallest_rotation(loop_.terms().X_WE.R.col(2), -n.normalized()).norm();
  }

  double dt() const { return e_.control.impedance.timing.dt; }

  // Runs and logs one control cycle. Returns false if the run is over.
  bool step(const PathSample& desired) {
    const double t = time(), step_time = state_->step_time, age = t - state_->state_time;
    while (waits_ && hooks_.held && hooks_.held(t)) {
    }
    if (watch_) watch_->update(t);
    const auto step_start = Clock::now();
    if (damped_end_.begun())
      damped_end_.damp(loop_.terms().M, reading_.confirmed(*state_), e_.scene.arm.limits().torque,
                       dt(), &out_);
    else if (!state_->stalled)
      out_ = guard_.braking() || retreats_ ? loop_.brake(*state_, velocity_of_retreat(desired))
                                           : loop_.step(*state_, desired.reference);
    if (watch_) watch_->feel(touch(), t);
    row_.step_time = seconds_since(step_start);
    row_.time = first_time_ + t;
    row_.time_scale = clock_.rate();
    fill_state(e_, *state_, driver_.truth(), desired, loop_, out_, &row_);

    driver_.command(out_.tau, out_.terms.col(kGravity));
    fill_contact(e_, driver_.truth(), out_.mode, &row_);
    if (log_) log_->append(row_);
    if (hooks_.row) hooks_.row(row_);
    count_status(out_.status, dt(), &outcome_.met);
    if (const JointStateEstimator* const estimator = loop_.joint_estimator())
      note_slow_velocity(*estimator, e_.control.joint_estimator->bandwidth,
                         &outcome_.slow_velocity);
    last_.add(row_, loop_, age);
    if (loop_.canvas().follows() && knows_canvas()) {
      known_for_ += dt();
      if (known_for_ > kSettled) history_.add(t, loop_.canvas().pose());
    }
    const bool inked = writes(e_, out_.mode, loop_.F_ext().head<3>().dot(out_.n_WD)) && in_place();
    ink_.add(desired.stroke, desired.along, inked);
    if (inked && desired.stroke >= 0) drawn_ += dt();

    state_ = &driver_.read();
    const std::string lost = lost_control(t);
    if (!lost.empty()) {
      if (retreats_) outcome_.cause += "; before the pen was up, " + lost;
      stop(RunEnd::stopped, lost);
      return false;
    }
    const bool lies = reading_.update(*state_, out_.tau - out_.terms.col(kGravity), external());
    if (damped_end_.begun()) return !damped_end_.over(reading_.confirmed(*state_)) || end_at_zero();
    if (lies) {
      damped_end_.begin();
      return halt(fmt::format("{} at t = {:.3f} s", reading_.cause(), first_time_ + time()));
    }
    if (hooks_.emergency && !halted_ && hooks_.emergency()) {
      if (!halt(fmt::format("emergency stop at t = {:.3f} s, by a person", first_time_ + t)))
        return false;
    } else if (fences_.update(loop_.terms().X_WE.p, loop_.terms().V_WE.head<3>(),
                              loop_.F_ext().head<3>(), dt(), loop_.F_ext().tail<3>(),
                              (out_.p_WD - loop_.terms().X_WE.p).norm())) {
      if (!halt(fmt::format("{} at t = {:.3f} s", fences_.crossed(), first_time_ + t)))
        return false;
    }
    since_pushed_ = is_pushed() ? 0.0 : since_pushed_ + dt();
    if (guard_.update(loop_.terms().v, out_.status.torque_limited, dt())) {
      const std::string& joint = e_.scene.arm.joint_names()[guard_.joint()];
      const std::string cause =
          guard_.swings()
              ? fmt::format("{} swung at t = {:.3f} s, with torques at their limits", joint,
                            first_time_ + t)
              : fmt::format("{} was above its speed limit of {:.2f} rad/s at t = {:.3f} s{}", joint,
                            e_.scene.arm.limits().speed[guard_.joint()], first_time_ + t,
                            out_.status.torque_limited ? ", with torques at their limits" : "");
      if (goes_on())
        damped_ = cause;
      else
        stop(RunEnd::stopped, cause);
      retreats_ = true;
    } else if (guard_.calmed()) {
      if (halted_) return end_at_zero();
      lift();
    }
    if (rattle_guard_.update(loop_.F_ext().head<3>().dot(out_.n_WD), out_.mode, out_.push,
                             loop_.surface().distance, dt()) &&
        !wall_) {
      unseen_ = rattle_guard_.unevenness() > RattleGuard::kUnseen && feels_walls() && !halted_;
      if (!unseen_) {
        const ImpedanceSettings& control = e_.control.impedance;
        stop(RunEnd::stopped,
             fmt::format("the pen hammered on the canvas at t = {:.3f} s, ± {:.2g} N at a "
                         "push of {:.3g} N: tip or canvas may be stiffer than "
                         "control.contact_stiffness_max, {:.3g} N/m",
                         first_time_ + t, rattle_guard_.deviation() * out_.push, out_.push,
                         control.stability_check.contact_stiffness_max));
        retreats_ = true;
        guard_.brake();
      }
    }
    if (watchdog_.update(step_time)) {
      stop(RunEnd::stopped,
           fmt::format("a control step took too long at t = {:.3f} s; the pen was lifted",
                       first_time_ + t));
      lift();
    }
    return true;
  }

  // Which of them; empty where the arm's state and the wrench are finite.
  std::string bad_input() const {
    const ArmTerms& arm = loop_.terms();
    if (!arm.M.allFinite() || !arm.g.allFinite()) return ", as joint positions,";
    if (!arm.v.allFinite()) return ", as joint velocities,";
    return loop_.F_ext().allFinite() ? "" : ", as the wrench,";
  }

  // Joint torques that are known to hold or turn the arm beside the law's motion: of what acts on
  // the tip, and of what the observer makes of the model's errors, up to a share of the limits.
  JointVector external() const {
    constexpr double kErrors = 0.2;
    Wrench F = loop_.F_ext();
    if (e_.control.impedance.wrench != WrenchFeedback::measured)
      F << out_.push * out_.n_WD, Eigen::Vector3d::Zero();
    const JointVector tau = loop_.terms().J.transpose().lazyProduct(F);
    return tau.cwiseAbs() +
           out_.terms.col(kDisturbance).cwiseAbs().cwiseMin(kErrors * e_.scene.arm.limits().torque);
  }

  // Zero beyond gravity is the last that the arm is sent.
  bool end_at_zero() {
    const JointVector gravity = out_.terms.col(kGravity);
    driver_.command(gravity, gravity);
    state_ = &driver_.read();
    return false;
  }

  // Why the run must end without lifting the pen; empty if it can continue. t: time of the last
  // commanded cycle [s].
  std::string lost_control(double t) {
    const bool blind_to_state = out_.status.bad_input || out_.status.stale_state;
    bad_state_ = blind_to_state ? bad_state_ + dt() : 0.0;
    if (!driver_.fault().empty()) return driver_.fault();
    if (bad_state_ > kBadStateTime)
      return fmt::format("the controller was given {} for {:.1f} s up to t = {:.3f} s",
                         out_.status.bad_input ? "numbers that are not finite" + bad_input()
                                               : std::string("joint states that are stale"),
                         kBadStateTime, first_time_ + t);
    const double hold = e_.plan.path_settings.start_hold;
    if (t > hold + raised_for_ && !loop_.tared())
      return fmt::format(
          "the wrench sensor could not be tared: within the first {:.2g} s the arm must rest for "
          "{:.2g} s, with no reading at its range",
          hold, e_.control.estimator.tare_time);
    return {};
  }

  // What the plan waits for on a canvas that moves; null: nothing.
  const char* waits_for(const PathSample& desired) const {
    if (loop_.canvas().lost()) return kToBeSeen;
    return rest_watch_.moves() && desired.stroke < 0 && out_.mode == ContactMode::free ? kToRest
                                                                                       : nullptr;
  }

  // A plan that has waited for kMostWait since it last drew ends the run.
  bool waits_too_long(const PathSample& desired) {
    const char* const what = paused() ? nullptr : waits_for(desired);
    const bool too_long = wait_.update(what, desired.stroke >= 0, dt());
    if (what) tell_wait(what, wait_.waited());
    if (!too_long) return false;
    const FrameMotion& canvas = loop_.canvas().estimate().motion;
    stop(RunEnd::stopped,
         what == kToBeSeen
             ? fmt::format("no camera has known the canvas for {:.0f} s, at t = {:.3f} s; the pen "
                           "was lifted",
                           kMostWait, first_time_ + time())
             : fmt::format("the canvas did not come to rest within {:.0f} s, at t = {:.3f} s: it "
                           "moves at {:.3g} mm/s under the pen, and rests below {:.2g} mm/s; "
                           "perception.frames.wait_for_rest=false draws on a canvas that moves",
                           kMostWait, first_time_ + time(),
                           1e3 * canvas.velocity_at(loop_.terms().X_WE.p).norm(),
                           0.5e3 * RestWatch::kMoves));
    let_go();
    return true;
  }

  // In the rhythm of the other progress.
  void tell_wait(const char* what, double waited) {
    if (!hooks_.progress || std::fmod(waited, 10.0 * dt()) >= dt()) return;
    RunProgress progress{first_time_ + time(), 0, 0, 0.0, 0.0, 0.0, false, what, waited};
    hooks_.progress(progress);
  }

  // How far the pen is from what the plan asks of it.
  PenDeviation deviation(const PathSample& desired, double planned) const {
    PenDeviation pen;
    pen.paused = paused() || waits_for(desired) != nullptr;
    if (!e_.scene.perception) return pen;
    pen.limit = forecast_.limit(planned);
    pen.joint =
        (loop_.terms().v.cwiseAbs().array() / e_.scene.arm.limits().speed.array()).maxCoeff();
    if (desired.stroke < 0) return pen;
    const Pose& X_WE = loop_.terms().X_WE;
    pen.waits = out_.mode == ContactMode::approach;
    pen.tilt = smallest_rotation(X_WE.R.col(2), -out_.axis_WD).norm();
    if (out_.mode != ContactMode::contact) return pen;
    pen.tip = behind().norm();
    // What frames confirm is the canvas's own motion, and no roughness.
    const double unexplained = watch_ ? 1.0 - watch_->felt().share(FeltMotion::along_normal) : 1.0;
    pen.normal_speed = unexplained * (out_.n_WD.dot(velocity_on_canvas()) - out_.rise);
    if (e_.control.impedance.wrench == WrenchFeedback::measured && out_.push > 0.0)
      pen.force = unexplained * (loop_.F_ext().head<3>().dot(out_.n_WD) - out_.push) / out_.push;
    return pen;
  }

  // What the canvas's motion is felt by.
  PenTouch touch() const {
    const ArmTerms& arm = loop_.terms();
    const bool touches = out_.mode == ContactMode::contact &&
                         e_.control.impedance.wrench == WrenchFeedback::measured;
    return {touches, arm.X_WE.p, arm.V_WE.head<3>(), out_.n_WD, loop_.F_ext().head<3>()};
  }

  // Of the tip, in W.
  Eigen::Vector3d velocity_on_canvas() const {
    const Eigen::Vector3d v = loop_.terms().V_WE.head<3>();
    const FrameMotion* const carrier = loop_.canvas().carrier();
    return carrier ? Eigen::Vector3d(v - carrier->velocity_at(loop_.terms().X_WE.p)) : v;
  }

  // Of the tip from the desired point, across the surface [m].
  Eigen::Vector3d behind() const {
    const Eigen::Vector3d off = out_.p_WD - loop_.terms().X_WE.p;
    return off - out_.n_WD * out_.n_WD.dot(off);
  }

  // The ink lies where it shall, as far as the arm knows.
  bool in_place() const { return !e_.scene.perception || behind().norm() < kInPlace; }

  // The place on a stroke where the plan is, or that it has come down to; with `ahead`, the first
  // point of the next stroke, too.
  static std::optional<StrokePart> place_on_path(const PathSample& desired, const TipPath& path,
                                                 double planned, bool ahead = false) {
    if (desired.stroke >= 0) return StrokePart{desired.stroke, desired.along, desired.along};
    for (const StrokeTimes& stroke : path.strokes()) {
      if (planned > stroke.end || (!ahead && planned < stroke.approach)) continue;
      const double along = path.at(std::max(planned, stroke.start + 1e-4)).along;
      return StrokePart{stroke.number, along, along};
    }
    return std::nullopt;
  }

  bool is_pushed() const {
    constexpr double kHand = 20.0;  // [N]
    return !((loop_.F_ext().head<3>() - out_.push * out_.n_WD).norm() < kHand);
  }

  // After a motion that the guard damped: where the arm drew well before, it is one place that it
  // cannot pass, a singular posture for instance, and not the arm, its set-up or a hand.
  bool goes_on() const {
    constexpr std::size_t kMost = 3;
    constexpr double kDrawn = 2.0, kAlone = 0.5;  // [s]
    return outcome_.end == RunEnd::finished && e_.scene.perception && !canvas_moves() && !halted_ &&
           !dry_run_ && outcome_.damped.size() < kMost && drawn_ > kDrawn && since_pushed_ > kAlone;
  }

  // True in the cycle in which the controller retreats from a place where the cameras have seen no
  // surface: a gap between two bodies, for instance. A fault of perception is none.
  bool lost_surface() {
    const bool before = std::exchange(retreating_, out_.mode == ContactMode::retreat);
    return retreating_ && !before && !canvas_moves() &&
           e_.scene.perception->estimate(loop_.terms().X_WE.p).status != SurfaceStatus::ok;
  }

  bool sinks(const PathSample& desired) {
    const bool touches =
        out_.mode == ContactMode::contact &&
        loop_.F_ext().head<3>().dot(out_.n_WD) > e_.control.impedance.contact.touch_force;
    if (touches) touched_ = {desired.stroke, desired.along, desired.along};
    const Eigen::Vector3d v = velocity_on_canvas();
    const double way = (v - out_.n_WD.dot(v) * out_.n_WD).norm() * dt();
    return sink_watch_.update(loop_.surface().distance, way, touches, dt());
  }

  bool feels_walls() const {
    return e_.scene.perception && e_.control.impedance.wrench == WrenchFeedback::measured;
  }

  void look_for_wall(const PathSample& desired, const TipPath& path, double planned) {
    if (!feels_walls()) return;
    const bool down = out_.mode == ContactMode::contact || out_.mode == ContactMode::approach;
    if (!down) {
      side_watch_.reset();
      sink_watch_.reset();
    }
    const bool sunk = down && !canvas_moves() && sinks(desired);
    const bool aside = down && side_watch_.update(out_.n_WD, loop_.F_ext().head<3>(), dt());
    const bool lost = lost_surface(), unseen = std::exchange(unseen_, false);
    if (sunk || aside || lost || unseen || state_->shaft_touches) {
      wall_ = place_on_path(desired, path, planned, state_->shaft_touches);
      if (wall_ && sunk && wall_->stroke == touched_.stroke)
        wall_->from = std::min(wall_->from, touched_.from);
      if (wall_) return lift(kLiftAtWall);
    }
    if (desired.stroke < 0 || out_.mode != ContactMode::contact) return wall_watch_.reset();
    const Eigen::Vector3d v_D = loop_.canvas().pose().R * desired.reference.v_WD;
    if (!wall_watch_.update(out_.n_WD, v_D, velocity_on_canvas(), behind(), loop_.F_ext().head<3>(),
                            dt()))
      return;
    wall_ = StrokePart{desired.stroke, desired.along - behind().norm(), desired.along};
    lift(kLiftAtWall);
  }

  // The canvas was lost, the pen let go of it, and now it is known again. The rest of the path
  // would be followed in the air.
  bool found_again() {
    const CanvasFollower& canvas = loop_.canvas();
    if (canvas.lost() && out_.mode == ContactMode::retreat) lost_canvas_ = true;
    return lost_canvas_ && !canvas.lost() && !lifting_;
  }

  // A canvas that moves may take the pen where the arm cannot follow. The pen then lets go of it.
  void look_for_reach() {
    constexpr double kLeftBehind = 15e-3;  // [m]
    constexpr double kConfirm = 0.1;       // [s]
    if (!loop_.canvas().joined()) return;
    const bool behind = (out_.p_WD - loop_.terms().X_WE.p).norm() > kLeftBehind;
    left_behind_ = behind ? left_behind_ + dt() : 0.0;
    if (left_behind_ < kConfirm) return;
    if (e_.scenario.preflight.arm) {
      left_reach_ = true;
      left_behind_ = 0.0;
      return let_go();
    }
    stop(RunEnd::stopped,
         fmt::format("the canvas left the arm's reach at t = {:.3f} s, at ({:.2f}, "
                     "{:.2f}, {:.2f}) m; the pen was lifted",
                     first_time_ + time(), out_.p_WD.x(), out_.p_WD.y(), out_.p_WD.z()));
    let_go();
  }

  bool off_a_moving_canvas() const {
    return loop_.canvas().joined() && out_.mode == ContactMode::free;
  }

  // The pen goes up and stays, wherever the canvas goes; that took it where the arm cannot follow.
  void let_go() {
    loop_.leave_canvas();
    lifting_.emplace(time(), e_.scene.arm.tip_pose(state_->q),
                     e_.control.impedance.surface.drawing_axis_W, kLiftOffCanvas);
  }
  // The same where the arm can follow still: a canvas that heaves does not catch up with the pen.
  void lift_off_canvas() {
    lifting_.emplace(time(), e_.scene.arm.tip_pose(state_->q),
                     e_.control.impedance.surface.drawing_axis_W, clear_height());
    loop_.leave_canvas(lifting_->duration());
  }

  // Up to where the run began, as far as the arm reaches [m].
  double clear_height() const {
    const Pose X_WE = e_.scene.arm.tip_pose(state_->q);
    const Eigen::Vector3d& up = e_.control.impedance.surface.drawing_axis_W;
    double height = std::max(kLiftOffCanvas, up.dot(e_.scenario.arm.start_p_WE - X_WE.p));
    while (height > kLiftOffCanvas &&
           !find_posture(e_.scene.arm, {X_WE.p + height * up, X_WE.R.col(2)}, state_->q).reached)
      height -= 0.02;
    return height;
  }

  // The arm of a run that was stopped still moves: a hand may have let go of it just now. Waits for
  // rest, but not for ever.
  bool swings(double t) const {
    constexpr double kRest = 0.5;  // of the fastest joint [rad/s]
    constexpr double kCalm = 2.0;  // at most [s]
    return retreats_ && loop_.terms().v.cwiseAbs().maxCoeff() > kRest && !lifting_->done(t - kCalm);
  }

  // Of the tip, in W: up, once the motion that the law lost control of has been damped.
  Eigen::Vector3d velocity_of_retreat(const PathSample& desired) const {
    if (guard_.braking() || !lifting_) return Eigen::Vector3d::Zero();
    return loop_.canvas().pose().R * desired.reference.v_WD;
  }

  bool paused() const { return !waits_ && hooks_.paused && hooks_.paused(); }

  void stop(RunEnd end, const std::string& cause) {
    if (outcome_.end != RunEnd::finished) return;
    outcome_.end = end;
    outcome_.cause = cause;
  }

  // Ends the run where the pen is. A driver damps in stop(), by its own session; the simulated arm
  // only ends there, so that the loop damps it first. Returns true if the loop goes on for that.
  bool halt(const std::string& cause) {
    const bool before = outcome_.end == RunEnd::stopped;
    outcome_.end = RunEnd::stopped;  // also while the pen of an interrupted run is lifted
    outcome_.cause = before ? outcome_.cause + "; then " + cause : cause;
    halted_ = true;
    if (!driver_.truth()) return false;
    guard_.brake();
    return true;
  }

  void lift(double height = EmergencyLift::kHeight) {
    const Eigen::Matrix3d R_KW = loop_.canvas().pose().R.transpose();
    if (!lifting_) lifting_.emplace(time(), X_KE(), R_KW * out_.n_WD, height);
  }

  Experiment& e_;
  Driver& driver_;
  const RunHooks& hooks_;
  bool waits_;                          // the driver, for the next command
  double first_time_;                   // of the log, where an earlier run left off [s]
  std::unique_ptr<CanvasWatch> watch_;  // null: one snapshot before the run
  ControlLoop loop_;
  Fences fences_;
  ReadingCheck reading_;
  DampedEnd damped_end_;
  LastSeconds last_;
  std::optional<double> dry_run_ = e_.scenario.drawing.dry_run;  // [m]
  bool halted_ = false;                                          // by a fence or an emergency stop
  RealTime real_time_;  // before the driver starts: its session begins in this thread
  StartedDriver started_;
  const ArmState* state_;  // the driver's last
  PlanClock clock_;
  JointForecast forecast_;
  SpeedGuard guard_;
  std::string damped_;         // why the guard damps the motion, if the drawing then goes on
  double drawn_ = 0.0;         // with ink, since the guard last did [s]
  double since_pushed_ = 0.0;  // since a force on the tip that the canvas does not explain [s]
  RattleGuard rattle_guard_;
  bool retreats_ = false;  // the law has lost control: the motion is damped, then the pen goes up
  WallWatch wall_watch_;
  SideWatch side_watch_;
  SinkWatch sink_watch_;
  StrokePart touched_{-1, 0.0, 0.0};  // where the surface held the tip last
  bool retreating_ = false;
  bool unseen_ = false;  // the pen hammers on what the cameras do not resolve
  RestWatch rest_watch_;
  std::optional<StrokePart> wall_;
  TouchedHeights heights_;
  double height_ = 0.0;    // of the tip above the plan of a stroke that is found by touch [m]
  double searched_ = 0.0;  // for a surface [s]
  StepWatchdog watchdog_;
  std::optional<RunLog> log_;
  LogRow row_;
  ImpedanceTorque out_;
  InkWatch ink_;
  RunOutcome outcome_;
  std::optional<EmergencyLift> lifting_;
  double raised_for_ = 0.0;   // before a resumed run begins to watch [s]
  double bad_state_ = 0.0;    // [s]
  double left_behind_ = 0.0;  // by the canvas [s]
  PlanWait wait_{kMostWait};
  // During the present path: in contact; the canvas went where the arm does not reach.
  bool lost_canvas_ = false, left_reach_ = false;
  std::size_t followed_ = 0;  // strokes of the present path
  const Between* between_ = nullptr;
  CanvasHistory history_;
  static constexpr double kSettled = 1.0;  // the first estimates are not yet of its motion [s]
  double known_for_ = 0.0;                 // of the canvas [s]
  TipReference rest_;                      // in W
};

// Throws OffSurface where the surface has ended.
TipPath path_for(Experiment& e, const std::vector<StrokePart>& parts, const Eigen::Vector3d& p_WE,
                 const Eigen::Vector3d& n_W, double hold) {
  return plan_from(e.plan.path_settings, e.surface(), strokes_of(e, parts), p_WE, n_W, hold,
                   stroke_limits(e.scene, e.plan));
}

// plan(parts). From another start the surface may end a little earlier, at its edges: what is
// missed there is taken out of the parts.
template <class PlanParts>
auto without_misses(const Experiment& e, std::vector<StrokePart>* parts, PlanParts&& plan) {
  while (true) {
    try {
      return plan(*parts);
    } catch (const OffSurface& off) {
      const double at = nearest_place(e.plan.strokes[static_cast<std::size_t>(off.stroke)], off.p);
      std::vector<StrokePart> done = rest_of(e.plan.strokes, *parts);
      done.push_back({off.stroke, at - OffSurface::kAbout, at + OffSurface::kAbout});
      std::vector<StrokePart> left = rest_of(e.plan.strokes, done, kShortestGap);
      if (plane_length(strokes_of(e, left)) >= plane_length(strokes_of(e, *parts))) throw;
      *parts = std::move(left);
    }
  }
}

// A path for the parts, without what it would miss. Empty if nothing is left.
TipPath plan_parts(Experiment& e, std::vector<StrokePart>* parts, const Eigen::Vector3d& p_WE,
                   const Eigen::Vector3d& n_W, double hold) {
  return without_misses(e, parts, [&](const std::vector<StrokePart>& left) {
    return left.empty() ? TipPath{} : path_for(e, left, p_WE, n_W, hold);
  });
}

// What lacks ink, but for the places before walls.
std::vector<StrokePart> rest_but_for(const Experiment& e, const InkWatch& ink,
                                     const std::vector<StrokePart>& walls) {
  std::vector<StrokePart> done = ink.parts();
  done.insert(done.end(), walls.begin(), walls.end());
  return rest_of(e.plan.strokes, done, kShortestGap);
}

// A path for it, from the posture q. The ways are others than those that were checked before the
// run: a stroke that they bar is given up, too.
std::optional<TipPath> plan_around(Experiment& e, const JointVector& q, const Pose& X_KE,
                                   const InkWatch& ink, std::vector<StrokePart>* walls) {
  PreflightSettings checks =
      preflight_settings(e.scenario, e.artwork.X_WP, e.scene.perception != nullptr, e.plan.rest_q);
  checks.height_error = height_error(e.scene);
  while (true) {
    std::vector<StrokePart> rest = rest_but_for(e, ink, *walls);
    TipPath path = plan_parts(e, &rest, X_KE.p, -X_KE.R.col(2), 0.0);
    if (rest.empty()) return std::nullopt;
    if (!e.scenario.preflight.arm) return path;
    std::vector<PlacedStroke> strokes = strokes_of(e, rest);
    for (std::size_t i = 0; i < strokes.size(); ++i) strokes[i].number = static_cast<int>(i);
    const std::vector<Finding> barred =
        check_transitions(path, strokes, e.scene.arm, e.scene.obstacle.get(), q, checks);
    if (barred.empty()) return path;
    for (const Finding& f : barred) {
      StrokePart part = rest[static_cast<std::size_t>(f.part.stroke)];
      if (f.way == WayEnd::none) {
        part.from = f.part.from - kBarredRoom;
        part.to = f.part.to + kBarredRoom;
      }
      walls->push_back(part);
    }
  }
}

// What an earlier run left undrawn.
std::vector<StrokePart> rest_of(const Experiment& e, const Resumption& resumption) {
  return rest_of(e.plan.strokes, resumption.ink.parts(), kShortestGap);
}

// A path for it, from the last posture.
TipPath plan_rest(Experiment& e, const Resumption& resumption) {
  std::vector<StrokePart> parts = rest_of(e, resumption);
  const Pose X_WE = e.scene.arm.tip_pose(resumption.q);
  return plan_parts(e, &parts, X_WE.p, -X_WE.R.col(2), e.plan.path_settings.start_hold);
}

// Draws on a canvas that moves: what and when is decided by its forecast (carried_plan.h).
class MovingDrawing {
 public:
  MovingDrawing(Experiment& e, Runner& runner, double first_time)
      : e_(e), runner_(runner), plan_(e, first_time), first_time_(first_time) {}

  // What is left of all strokes, but for walls and what is out of reach.
  std::vector<StrokePart> rest() const {
    std::vector<StrokePart> done = runner_.outcome().walls;
    for (const UnreachedPart& u : runner_.outcome().unreached) done.push_back(u.part);
    return rest_but_for(e_, runner_.ink(), done);
  }

  void draw(std::vector<StrokePart> pending, bool again) {
    waited_ = 0.0;
    for (int losses = 0; finished() && !pending.empty() && losses <= kMostLosses;) {
      const CarriedDecision next = without_misses(
          e_, &pending, [this](const std::vector<StrokePart>& left) { return decide(left); });
      for (const std::string& remark : next.remarks) remark_on(remark);
      give_up(next.lost, &pending);
      if (!finished()) return;
      if (next.kind == CarriedDecision::Kind::nothing) continue;
      if (next.kind == CarriedDecision::Kind::wait) {
        if (!wait(next, &pending)) return;
        continue;
      }
      waited_ = 0.0;
      if (!runner_.joined()) runner_.join(next.join);
      runner_.follow(next.path, again, [this](const TipPath& path, double planned) {
        return !e_.scenario.preflight.arm ||
               plan_.holds(path, planned, runner_.forecast(), runner_.pen());
      });
      if (!finished()) return;
      if (runner_.wall()) {
        if (!keep_off(*runner_.wall())) return;
      } else if (runner_.left_reach()) {
        if (!left_at(next.parts, runner_.strokes_followed())) return;
      } else if (runner_.lost_canvas()) {
        ++losses;
      } else {
        // A gap within what was followed is drawn later, with others.
        for (std::size_t i = 0; i < runner_.strokes_followed(); ++i)
          std::erase_if(pending, [&](const StrokePart& p) {
            return p.stroke == next.parts[i].stroke && p.from == next.parts[i].from;
          });
        continue;
      }
      pending = rest();
    }
  }

 private:
  bool finished() const { return runner_.outcome().end == RunEnd::finished; }

  CarriedDecision decide(const std::vector<StrokePart>& pending) {
    if (pending.empty()) return {};
    const CarriedPen pen = runner_.pen();
    if (e_.scenario.preflight.arm) return plan_.decide(pending, runner_.forecast(), pen);
    CarriedDecision all;
    all.kind = CarriedDecision::Kind::draw;
    all.join = pen.joined ? 0.0 : CanvasFollower::kJoin;
    const Pose here = runner_.X_KE();
    all.path = path_for(e_, pending, here.p, -here.R.col(2), all.join);
    all.parts = pending;
    return all;
  }

  void remark_on(const std::string& remark) {
    std::vector<std::string>& remarks = runner_.outcome().remarks;
    const auto about = [](const std::string& r) {  // without times that were forecast anew
      return r.substr(0, std::min(r.find(" from "), r.find(':')));
    };
    if (std::none_of(remarks.begin(), remarks.end(),
                     [&](const std::string& r) { return about(r) == about(remark); }))
      remarks.push_back(remark);
  }

  // Leaves them out, or ends the run.
  void give_up(const std::vector<UnreachedPart>& lost, std::vector<StrokePart>* pending) {
    for (const UnreachedPart& u : lost) {
      runner_.outcome().unreached.push_back(u);
      std::erase_if(*pending, [&](const StrokePart& p) {
        return p.stroke == u.part.stroke && p.from == u.part.from;
      });
    }
    if (lost.empty() || e_.scenario.drawing.skip_unreachable) return;
    if (runner_.joined()) runner_.retire();
    runner_.end(lost.front().text +
                (lost.size() == 1 ? "" : fmt::format(", and {} more", lost.size() - 1)) +
                "; --skip-unreachable draws the rest");
  }

  // Returns false if the run is over.
  bool wait(const CarriedDecision& next, std::vector<StrokePart>* pending) {
    const double begin = runner_.time();
    if (runner_.joined()) runner_.retire();
    // Forecasts are made anew: the motion may change.
    constexpr double kLongest = 1.0;  // [s]
    if (finished() && next.place_W)
      runner_.go_to(*next.place_W, next.until);
    else if (finished())
      runner_.wait(std::clamp(next.until, runner_.time() + 0.05, runner_.time() + kLongest),
                   "a stroke to come into reach");
    waited_ += runner_.time() - begin;
    if (!finished() || waited_ < kMostWait) return finished();
    std::vector<UnreachedPart> lost;
    for (const StrokePart& part : *pending) lost.push_back({part, next.why});
    give_up(lost, pending);
    return finished();
  }

  // The canvas went out of reach although the forecast did not say so.
  bool left_at(const std::vector<StrokePart>& parts, std::size_t stroke) {
    if (++left_ < kMostLeft) return true;
    const StrokePart& part = parts[std::min(stroke, parts.size() - 1)];
    std::vector<StrokePart> none;
    give_up(
        {{part, fmt::format("stroke {} left the arm's reach at t = {:.1f} s, {} times",
                            plan_.number_of(part.stroke), first_time_ + runner_.time(), left_)}},
        &none);
    left_ = 0;
    return finished();
  }

  bool keep_off(const StrokePart& at) {
    std::vector<StrokePart>& walls = runner_.outcome().walls;
    beyond_ = !walls.empty() && walls.back().stroke == at.stroke &&
                      std::abs(walls.back().to - at.to) < kSameWall
                  ? 2.0 * beyond_
                  : kBeyondWall;
    walls.push_back({at.stroke, at.from - kRedrawOverlap, at.to + beyond_});
    return walls.size() < kMostWalls;
  }

  Experiment& e_;
  Runner& runner_;
  CarriedPlan plan_;
  double first_time_;
  double waited_ = 0.0;  // since a stroke was followed [s]
  double beyond_ = kBeyondWall;
  int left_ = 0;
};

// What lacks ink, by the reason for which it was given up [m].
std::map<std::string, double> given_up(const Experiment& e, const std::vector<StrokePart>& lacking,
                                       const RunOutcome& outcome) {
  std::vector<StrokePart> unreached;
  for (const UnreachedPart& u : outcome.unreached) unreached.push_back(u.part);
  std::map<std::string, double> lengths;
  if (e.scenario.drawing.dry_run) return lengths;
  for (const StrokePart& part : lacking)
    if (is_at_wall(part, outcome.walls))
      lengths["wall"] += part.length();
    else if (is_at_wall(part, unreached))
      lengths["out_of_reach"] += part.length();
  return lengths;
}

}  // namespace

bool is_at_wall(const StrokePart& part, const std::vector<StrokePart>& walls) {
  return std::any_of(walls.begin(), walls.end(), [&part](const StrokePart& wall) {
    return wall.stroke == part.stroke && wall.from < part.to && part.from < wall.to;
  });
}

std::vector<PlacedStroke> strokes_of(const Experiment& e, const std::vector<StrokePart>& parts) {
  std::vector<PlacedStroke> strokes;
  for (const StrokePart& part : parts) {
    const PlacedStroke& whole = e.plan.strokes[static_cast<std::size_t>(part.stroke)];
    strokes.push_back(part.from <= 0.0 && part.to >= plane_length(whole)
                          ? whole
                          : part_of(whole, part.from - kRedrawOverlap, part.to + kRedrawOverlap));
  }
  return strokes;
}

bool writes(const Experiment& e, ContactMode mode, double normal_force) {
  const ImpedanceSettings& control = e.control.impedance;
  const bool measured = control.wrench == WrenchFeedback::measured;
  if (measured && !(normal_force >= InkWatch::least_force(control.normal_force))) return false;
  // Blind, the law has no contact state. Without a wrench too, contact is unknown.
  return !e.scene.estimates_surface() || mode == ContactMode::contact;
}

RunOutcome run(Experiment& e, Driver& driver, const std::filesystem::path& log_file,
               double start_up, const RunHooks& hooks, const Resumption* resumption) {
  if (e.scenario.drawing.dry_run && e.scene.by_touch())
    throw InputError(
        "drawing.dry_run: the surface is found by touch, so that nothing tells its height; valid "
        "is null, or perception.enabled true");
  const auto before_log = Clock::now();
  const TipPath rest = resumption && !follows_canvas(e) ? plan_rest(e, *resumption) : TipPath();
  const TipPath& path = resumption ? rest : e.plan.path;
  Runner runner(e, driver, log_file, hooks, resumption);
  if (hooks.begun) hooks.begun();
  RunOutcome& outcome = runner.outcome();
  outcome.wall.start_up = start_up + seconds_since(before_log);

  const auto loop_start = Clock::now();
  const bool by_touch = e.scene.by_touch();
  if (by_touch)
    runner.feel(resumption ? strokes_of(e, rest_of(e, *resumption)) : e.plan.strokes,
                e.plan.path_settings.start_hold, false);
  else if (!follows_canvas(e))
    runner.follow(path, false);
  const auto lacking = [&] { return rest_of(e.plan.strokes, runner.ink().parts(), kShortestGap); };
  std::vector<StrokePart>& walls = outcome.walls;
  double beyond = kBeyondWall;
  // Goes around the wall that ended a path: plans what lacks ink, from where the pen now is. Each
  // further attempt at the same wall keeps twice as far off it.
  const auto go_around = [&](bool again) {
    while (outcome.end == RunEnd::finished && runner.wall() && walls.size() < kMostWalls) {
      const StrokePart at = *runner.wall();
      beyond = !walls.empty() && walls.back().stroke == at.stroke &&
                       std::abs(walls.back().to - at.to) < kSameWall
                   ? 2.0 * beyond
                   : kBeyondWall;
      walls.push_back({at.stroke, at.from - kRedrawOverlap, at.to + beyond});
      const std::optional<TipPath> around =
          plan_around(e, runner.q(), runner.X_KE(), runner.ink(), &walls);
      if (!around) return;
      runner.follow(*around, again);
    }
  };
  go_around(false);
  std::optional<MovingDrawing> moving;
  if (follows_canvas(e)) {
    moving.emplace(e, runner, resumption ? resumption->time : 0.0);
    runner.watch();
    if (outcome.end == RunEnd::finished) moving->draw(moving->rest(), false);
  }
  if (outcome.end == RunEnd::finished && !e.scenario.drawing.dry_run && e.scenario.drawing.redraw) {
    outcome.drawn_again = moving ? moving->rest() : rest_but_for(e, runner.ink(), walls);
    const Pose here = runner.X_KE();
    const TipReference last = path.at(path.duration()).reference;
    if (outcome.drawn_again.empty()) {
    } else if (moving) {
      moving->draw(outcome.drawn_again, true);
    } else if (by_touch) {
      runner.feel(strokes_of(e, outcome.drawn_again), 0.0, true);
    } else {
      const bool turned = !walls.empty();  // the pen is not at the plan's end
      const TipPath again = plan_parts(e, &outcome.drawn_again, turned ? here.p : last.p_WD,
                                       turned ? Eigen::Vector3d(-here.R.col(2)) : last.n_WD, 0.0);
      if (!outcome.drawn_again.empty()) {
        runner.follow(again, true);
        go_around(true);
      }
    }
  }
  if (outcome.end == RunEnd::finished && !e.scenario.drawing.dry_run) outcome.lacking = lacking();
  outcome.given_up = given_up(e, lacking(), outcome);
  runner.keep_last();
  outcome.simulated = runner.time();
  if (const GroundTruth* truth = driver.truth()) outcome.cutoffs = truth->cutoffs;
  outcome.first_time = resumption ? resumption->time : 0.0;
  outcome.wall.loop = seconds_since(loop_start);
  outcome.wall = runner.close_log(outcome.wall);
  return outcome;
}

RunOutcome run(Experiment& e, const std::filesystem::path& log_file, double start_up,
               const RunHooks& hooks, const Resumption* resumption) {
  if (e.scenario.arm.driver != ArmDriver::sim)
    throw InputError(
        "arm.driver is not sim, and only ./impedraw draw drives such an arm; valid here is sim");
  SimulatedArm arm(e, resumption ? resumption->q : e.scene.start_q, disturbances_of(e, resumption),
                   resumption ? resumption->time : 0.0);
  return run(e, arm, log_file, start_up, hooks, resumption);
}

}  // namespace impedraw

#include "impedraw/run/simulated_arm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "impedraw/experiment/snapshot.h"
#include "impedraw/terminal/progress.h"

namespace impedraw {
namespace {

constexpr double kMostBrush = 1.0;  // a shaft that touches for longer does not get away [s]
constexpr double kRunaway = 20.0;   // joint speed [rad/s], near ten times what such an arm can

constexpr std::size_t kMostComing = 4096;
constexpr double kSkin = 5e-3;  // what is hit this close before a mark is the mark itself [m]

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
  if (scenario_.perception.frames.enabled) cameras_.emplace(scenario_, world_, canvas_, arm_);
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
  TipMaterial tip = scenario_.world.tip;
  double longer = errors.pen_longer;
  if (const auto i = static_cast<std::size_t>(number); number >= 0) {
    const LayerPenSettings& pen = scenario_.pens[i];
    if (i < errors.pens_longer.size()) longer = errors.pens_longer[i];
    longer += pen.longer.value_or(0.0);
    tip.radius = pen.radius.value_or(tip.radius);
  }
  world_.set_tip(tip);
  world_.set_pen_longer(longer);
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

SimulatedCameras::SimulatedCameras(const Scenario& scenario, World& world, const Canvas& canvas,
                                   const ArmModel& arm, int threads)
    : world_(world),
      canvas_(canvas),
      arm_(arm),
      noise_(scenario.perception.noise),
      depth_scale_(1.0 + scenario.perception.errors.depth_scale),
      time_stamp_(scenario.perception.errors.time_stamp),
      frames_(scenario.perception.frames),
      fiducials_(scenario.perception.fiducials) {
  for (std::size_t i = 0; i < scenario.perception.cameras.size(); ++i) {
    const CameraSettings& c = scenario.perception.cameras[i];
    const DepthCamera believed = {frames_.width, frames_.height, c.fov_y_deg,
                                  look_at(c.p_WC, c.target_W)};
    const std::uint64_t seed = camera_seed(scenario, i);
    cameras_.push_back({believed, true_camera(believed, scenario.perception.errors, seed), 0, seed,
                        SeededNormals(seed ^ 0x6672616d65)});
  }
  for (const Camera& camera : cameras_) validate(camera.actual);
  coming_.reserve(kMostComing);
  unused_.reserve(kMostComing);
  if (threads == 0) threads = std::thread::hardware_concurrency() > 1 ? 2 : 1;
  if (frames_.depth && threads > 1) second_ = std::thread([this] { render_what_is_queued(); });
}

SimulatedCameras::~SimulatedCameras() {
  if (!second_.joinable()) return;
  ends_ = true;
  ++posted_;
  posted_.notify_one();
  second_.join();
}

bool SimulatedCameras::sees(const DepthCamera& camera, const Eigen::Vector3d& p_W,
                            const Pose& X_WK) const noexcept {
  const Eigen::Vector3d p_C = camera.X_WC.inverse() * p_W;
  if (p_C.z() <= 0.0) return false;
  const double f = camera.focal_length();
  if (std::abs(p_C.x() / p_C.z()) * f > 0.5 * camera.width ||
      std::abs(p_C.y() / p_C.z()) * f > 0.5 * camera.height)
    return false;
  const Eigen::Vector3d way = p_W - camera.X_WC.p;
  const double distance = way.norm();
  const Eigen::Vector3d direction = way / distance;
  if (world_.ray_to_arm(camera.X_WC.p, direction) < distance - kSkin) return false;
  const auto hit = canvas_.ray(X_WK.inverse() * camera.X_WC.p, X_WK.R.transpose() * direction);
  return !hit || hit->t > distance - kSkin;
}

SimulatedCameras::Coming* SimulatedCameras::unused() {
  if (unused_.empty()) {
    all_.push_back(std::make_unique<Coming>());
    return all_.back().get();
  }
  Coming* const coming = unused_.back();
  unused_.pop_back();
  return coming;
}

void SimulatedCameras::capture(int number, double time, bool lost) noexcept {
  Camera& camera = cameras_[static_cast<std::size_t>(number)];
  const Pose X_WK = world_.canvas_state().X_WK;
  CanvasFrame frame;
  frame.time = time + time_stamp_;
  frame.camera = number;
  // Drawn for each frame, also of those that are lost, so that one does not change the next.
  const double late = frames_.latency + frames_.latency_jitter * camera.noise.next();
  const bool dropped = std::erfc(-camera.noise.next() / std::sqrt(2.0)) / 2.0 < frames_.drop;
  const Pose error = camera.believed.X_WC * camera.actual.X_WC.inverse();
  for (std::size_t i = 0; i < fiducials_.points.size() && i < CanvasFrame::kMostMarks; ++i) {
    Eigen::Vector3d noise;
    for (int k = 0; k < 3; ++k) noise[k] = fiducials_.noise * camera.noise.next();
    const Eigen::Vector3d p_W = X_WK * fiducials_.points[i].p_K;
    if (!sees(camera.actual, p_W, X_WK)) continue;
    frame.marks[static_cast<std::size_t>(frame.count++)] = {static_cast<int>(i),
                                                            error * p_W + noise};
  }
  if (dropped || lost || coming_.size() == kMostComing) return;
  Coming* const coming = unused();
  coming->frame = frame;
  coming->arrives = time + std::max(0.0, late);
  coming->has_depth =
      frames_.depth && camera.exposed % static_cast<std::uint64_t>(frames_.depth_every) == 0;
  const auto at = std::upper_bound(
      coming_.begin(), coming_.end(), coming->arrives,
      [](double arrives, const Coming* other) { return arrives < other->arrives; });
  coming_.insert(at, coming);
  if (!coming->has_depth) return;
  coming->seed = camera.seed + (camera.exposed << 20);
  coming->X_WK = X_WK;
  world_.copy_body(&coming->body);
  coming->arm.clear();
  for (const BodyCapsule& c : arm_.body_capsules(world_.state().q))
    coming->arm.push_back({c.a_W, c.b_W, c.radius});
  coming->stage.store(Coming::waiting, std::memory_order_release);
  if (!second_.joinable() || !queue_.give(coming)) return;
  ++posted_;
  posted_.notify_one();
}

void SimulatedCameras::render_if_waiting(Coming* coming) const noexcept {
  int expected = Coming::waiting;
  if (!coming->stage.compare_exchange_strong(expected, Coming::begun, std::memory_order_acq_rel))
    return;
  const DepthCamera& camera = cameras_[static_cast<std::size_t>(coming->frame.camera)].actual;
  const CastRays cast = [this, coming](const Eigen::Vector3d& o_W,
                                       std::span<const Eigen::Vector3d> d_W,
                                       std::span<double> distances) {
    constexpr std::size_t kBatch = 64;
    std::array<Eigen::Vector3d, kBatch> d_K;
    const Pose X_KW = coming->X_WK.inverse();
    const Eigen::Vector3d o_K = X_KW * o_W;
    for (std::size_t first = 0; first < d_W.size(); first += kBatch) {
      const std::size_t n = std::min(kBatch, d_W.size() - first);
      for (std::size_t k = 0; k < n; ++k) d_K[k] = X_KW.R * d_W[first + k];
      canvas_.rays(o_K, {d_K.data(), n}, distances.subspan(first, n));
    }
    coming->body.cover(o_W, d_W, distances, PosedBody::Rays::finite);
  };
  const PixelBox part = frames_.region_of_interest
                            ? pixels_of(camera, canvas_.bounds(), coming->X_WK)
                            : PixelBox{0, 0, camera.width, camera.height};
  render_depth(camera, cast, noise_, coming->seed, part, &coming->image);
  if (depth_scale_ != 1.0)
    for (double& depth : coming->image.depth) depth *= depth_scale_;
  coming->stage.store(Coming::done, std::memory_order_release);
  coming->stage.notify_all();
}

void SimulatedCameras::render_what_is_queued() noexcept {
  while (true) {
    const unsigned seen = posted_.load();
    if (ends_) return;
    Coming* coming = nullptr;
    if (queue_.take(&coming))
      render_if_waiting(coming);
    else
      posted_.wait(seen);
  }
}

void SimulatedCameras::expose(bool lost) noexcept {
  const double time = world_.state().time;
  bool posed = false;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Camera& camera = cameras_[i];
    const double due =
        static_cast<double>(camera.exposed) / frames_.rate + static_cast<double>(i) * frames_.skew;
    if (time < due - 1e-9) continue;
    if (!posed) world_.pose_body();
    posed = true;
    capture(static_cast<int>(i), time, lost);
    ++camera.exposed;
  }
}

bool SimulatedCameras::next(double time, CanvasFrame* frame) noexcept {
  if (coming_.empty() || coming_.front()->arrives > time) return false;
  if (given_) unused_.push_back(given_);
  given_ = coming_.front();
  coming_.erase(coming_.begin());
  *frame = given_->frame;
  if (!given_->has_depth) return true;
  render_if_waiting(given_);
  while (given_->stage.load(std::memory_order_acquire) == Coming::begun)
    given_->stage.wait(Coming::begun, std::memory_order_acquire);
  frame->depth = &given_->image;
  frame->camera_model = &cameras_[static_cast<std::size_t>(frame->camera)].believed;
  frame->arm = given_->arm;
  return true;
}

RunOutcome run(Prepared& e, const std::filesystem::path& log_file, double start_up,
               const RunHooks& hooks, const Resumption* resumption) {
  const auto arm = simulated(e)(resumption ? resumption->q : e.belief.start_q, resumption);
  return run(e, *arm, log_file, start_up, hooks, resumption);
}

Drawing draw_into(const std::filesystem::path& folder, Prepared& e, double start_up, bool resume,
                  const RunHooks& watch, const DriverMaker& make_driver) {
  return draw_into(folder, e, make_driver ? make_driver : simulated(e), start_up, resume, watch);
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

#include "impedraw/judge/force_trial.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <thread>
#include <variant>

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <Eigen/QR>

#include "impedraw/common/rotations.h"
#include "impedraw/common/seeded_normals.h"
#include "impedraw/control/joint_speed_shares.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/judge/force_rig.h"
#include "impedraw/run/motion_check.h"
#include "impedraw/run/simulated_arm.h"

namespace impedraw {
namespace {

constexpr double kHeightError = 5e-4;                          // [m]
constexpr double kTiltError = 0.5 * std::numbers::pi / 180.0;  // [rad]
constexpr double kTouch = 0.05;                                // [N]
constexpr double kMostForce = 100.0;                           // ends a run [N]
constexpr double kMostSpeed = 0.85;  // the same, of a joint's rated one: it still speeds up then
constexpr double kCalm = 1.0;        // longest damping after it [s]

Pose belief_error(int seed) {
  SeededNormals normals(static_cast<std::uint64_t>(seed));
  Pose X;
  X.p.z() = kHeightError * normals.next();
  const double about_x = kTiltError * normals.next();
  X.R = rotation({about_x, kTiltError * normals.next(), 0.0});
  return X;
}

// The torque that the next cycle sends.
struct Torque {
  JointVector tau, gravity;
};

}  // namespace

// The three controllers, behind one step.
struct ForceBench::Law {
  Law(const Experiment& e, const DriverInfo& info, ForceController controller,
      const Workpiece& believed, double approach_speed)
      : arm(e.belief.arm), terms(arm.joints()) {
    if (controller == ForceController::ours) {
      ControlSetup setup = e.control;
      setup.impedance.approach.speed = approach_speed;
      // No clock slows down the path where it asks too much, as in a drawing: the law has to.
      Eigen::VectorXd& most = setup.impedance.limits.joint_speed;
      most = most.cwiseMin(JointSpeedShares::kPlanned * arm.limits().speed);
      law.emplace<std::unique_ptr<ControlLoop>>(std::make_unique<ControlLoop>(
          setup, arm, info,
          [believed](const Eigen::Vector3d& p_K, double) { return believed.estimate(p_K); }));
      return;
    }
    if (!info.velocity)
      throw InputError(
          "controllers: crisp and impedance need measured joint velocities, and the arm gives "
          "none; valid is --controllers ours");
    const JointVector q_0 = e.plan.rest_q;
    if (controller == ForceController::crisp)
      law.emplace<CrispLaw>(q_0);
    else
      law.emplace<FeedforwardLaw>(q_0);
  }

  Torque step(const ArmState& state, const ForceCommand& command) {
    if (auto* const loop = std::get_if<std::unique_ptr<ControlLoop>>(&law)) {
      const ImpedanceTorque& out = (*loop)->step(state, command.reference);
      terms = (*loop)->terms();
      return {out.tau, out.terms.col(kGravity)};
    }
    arm.compute(state.q, state.v, &terms);
    if (auto* const crisp = std::get_if<CrispLaw>(&law))
      return {crisp->step(terms, command.reference, command.press), terms.g};
    return {std::get<FeedforwardLaw>(law).step(terms, command.reference, command.press), terms.g};
  }

  // A wrench that the controller needs is known.
  bool tared() const {
    const auto* const loop = std::get_if<std::unique_ptr<ControlLoop>>(&law);
    return !loop || (*loop)->tared();
  }

  ArmModel arm;
  ArmTerms terms;  // of the last step
  std::variant<std::monostate, std::unique_ptr<ControlLoop>, CrispLaw, FeedforwardLaw> law;
};

ForceBench::ForceBench(Prepared& e, const DriverMaker& make_driver, bool has_sensor,
                       std::filesystem::path rig)
    : e_(e), as_given_(e.scenario), rig_(std::move(rig)) {
  piece_.p_W += e.scenario.canvas.move;
  if (!make_driver) return;
  driver_ = make_driver(e.belief.start_q, nullptr);
  if (driver_->info().wrench != WrenchReading::tip && !has_sensor)
    throw InputError(
        "judge-force: nothing measures the force: this arm gives no wrench at its tip; valid is "
        "--sensor FILE with the readings of a sensor under the workpiece, arm.driver sim, or "
        "iiwa-lcm with control.wrench: ground_truth");
  driver_->start();
  hold();
}

ForceBench::~ForceBench() {
  held_.reset();
  if (driver_) driver_->stop();
}

std::string ForceBench::fault() const {
  return driver_ && (!held_ || held_->failed()) ? driver_->fault() : std::string();
}

// Controllers are made, and runs are judged, between two runs. Only an arm in lock-step waits.
void ForceBench::hold() {
  if (!driver_->info().waits) held_.emplace(*driver_, e_.belief.arm, state_);
}

// Makes the simulated world anew, if its workpiece has another shape.
void ForceBench::set_shape(Workpiece::Shape shape) {
  if (shape_ == shape) return;
  WorldSettings settings = as_given_.world;
  settings.flange_sensor = has_sensor(as_given_.control.source);
  if (settings.errors.rotor_inertia.empty() && !settings.joint_spring.on()) {
    const Eigen::VectorXd& rotors = e_.belief.arm.rotor_inertia();
    settings.errors.rotor_inertia.assign(rotors.begin(), rotors.end());
  }
  Workpiece piece = piece_;
  piece.shape = shape;
  e_.truth.world.reset();
  e_.truth.canvas = std::make_shared<Canvas>(piece.mesh());
  e_.truth.world = std::make_unique<World>(urdf_of(as_given_.arm), e_.truth.canvas.get(), settings);
  shape_ = shape;
}

ForceRun ForceBench::run(const ForceCase& c, ForceController controller, int seed,
                         const std::function<bool()>& go_on) {
  Workpiece believed = piece_;
  believed.shape = c.shape;
  believed.X_WB = belief_error(seed);
  const TipMaterial tip = as_given_.world.tip;

  const auto programme_from = [&](const JointVector& q) {
    const Pose X_WE = ArmModel(e_.belief.arm).tip_pose(q);
    return ForceProgramme(c, believed, X_WE.p, -X_WE.R.col(2));
  };
  std::optional<SimulatedArm> simulated;
  Driver* driver = driver_.get();
  World* world = nullptr;
  if (!driver) {
    const double start = programme_from(e_.belief.start_q).start();
    set_shape(c.shape);
    world = e_.truth.world.get();
    world->move_canvas(motion_of(c, piece_, start));
    world->set_tip(tip);
    e_.scenario.seed = as_given_.seed + seed;
    simulated.emplace(
        e_, e_.belief.start_q,
        c.hand ? Disturbances(*c.hand, start + ForceProgramme::kHand) : Disturbances());
    driver = &*simulated;
    driver->start();
  }
  // A driven arm's last state of the run before waits for its answer.
  const ArmState* state = held_ ? nullptr : driver_ && state_ ? state_ : &driver->read();
  const ForceProgramme programme = programme_from(world   ? e_.belief.start_q
                                                  : held_ ? held_->posture()
                                                          : state->q);
  if (!rig_.empty()) write_whole(rig_, rig_order(c, piece_, programme, ++orders_));

  ForceRun run;
  run.record.reserve(static_cast<std::size_t>(programme.leave() / driver->info().period) + 1);
  Law law(e_, driver->info(), controller, believed, c.approach_speed);
  const bool measured = world || driver->info().wrench == WrenchReading::tip;
  if (held_) state = held_->release();
  held_.reset();
  const double begin = state->time, end = driver_ ? programme.leave() : programme.end();
  for (double t = 0.0; t < end; t = state->time - begin) {
    const ForceCommand command = programme.at(t);
    if (world && c.stiffness) {
      TipMaterial now = tip;
      now.stiffness = c.stiffness_at(programme.share(t));
      now.damping = tip.damping * std::sqrt(now.stiffness / tip.stiffness);
      world->set_tip(now);
    }
    const Torque torque = law.step(*state, command);
    const Eigen::Vector3d n_W = command.reference.n_WD;
    double force = measured ? state->wrench.head<3>().dot(n_W) : std::nan("");
    driver->command(torque.tau, torque.gravity);
    if (const GroundTruth* const truth = driver->truth()) {
      const Eigen::Vector3d normal = truth->X_WK.R * truth->contact_normal;
      force = normal.allFinite() ? normal.dot(truth->contact_force) : 0.0;
    }
    const Eigen::Vector3d v = law.terms.V_WE.head<3>();
    run.record.push_back({t, command.asked, force, (v - n_W * n_W.dot(v)).norm()});
    // A workpiece on springs gives way as a whole: the pen's shaft stays clear of it.
    if (world && c.stiffness) world->forget_touching_link();
    state = &driver->read();
    if (!driver->fault().empty()) run.ended = driver->fault();
    // A driven arm would end its session, and with it every later run.
    Eigen::Index j = 0;
    const JointVector& rated = e_.belief.arm.limits().speed;
    if (driver_ && (state->v.cwiseAbs() - kMostSpeed * rated).maxCoeff(&j) > 0.0)
      run.ended = fmt::format("joint {} turned at {:.2f} rad/s; it is rated for {:.2f}", j + 1,
                              std::abs(state->v[j]), rated[j]);
    if (std::abs(force) > kMostForce) run.ended = fmt::format("force of {:.0f} N", force);
    if (t > programme.descent() && !law.tared())
      run.ended = "the arm was not at rest long enough to tare its sensor";
    if (!go_on()) run.ended = "interrupted";
    if (!run.ended.empty()) break;
  }
  if (driver_) make_ready(run, &law, state);
  run.begin = begin;
  run.order = orders_;
  run.programme = programme;
  if (measured) run.ask();
  return run;
}

void ForceBench::make_ready(const ForceRun& run, Law* law, const ArmState* state) {
  const double ended = state->time;
  while (!run.ended.empty() && driver_->fault().empty() &&
         state->v.cwiseAbs().maxCoeff() > kDampedSpeed && state->time < ended + kCalm) {
    law->arm.compute(state->q, state->v, &law->terms);
    driver_->command(law->terms.g + damping_torque(law->terms.M, state->v), law->terms.g);
    state = &driver_->read();
  }
  state_ = state;
  if (!driver_->fault().empty()) {
    driver_->stop();
    JointVector q;
    if (e_.scenario.arm.recoveries == 0 || !driver_->recover(&q)) return;
    driver_->start();
    state_ = nullptr;
  }
  hold();
}

void ForceRun::ask() {
  const double from = programme->descent();
  const auto touch = std::find_if(record.begin(), record.end(), [&](const JudgedSample& s) {
    return s.time > from && s.force > kTouch;
  });
  if (touch != record.end())
    question = programme->question(touch->time);
  else if (ended.empty())
    ended = "never touched the workpiece";
}

SensorFile::SensorFile(const std::filesystem::path& file, double patience) {
  for (double waited = 0.0; !std::filesystem::exists(file); waited += 0.1) {
    if (waited > patience)
      throw InputError(fmt::format("--sensor {}: no such file {:.0f} s after the last run",
                                   file.string(), patience));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);  // the columns' names
  const bool has_runs = line.starts_with("run");
  for (int number = 2; std::getline(in, line); ++number) {
    Reading r;
    const bool read = has_runs
                          ? std::sscanf(line.c_str(), "%d,%lf,%lf", &r.run, &r.time, &r.force) == 3
                          : std::sscanf(line.c_str(), "%lf,%lf", &r.time, &r.force) == 2;
    if (!read || (!readings_.empty() && !readings_.back().before(r)))
      throw InputError(fmt::format(
          "--sensor {}:{}: valid is {}a time [s], later than the line before, a comma and a force "
          "[N]",
          file.string(), number, has_runs ? "the number of a run, a comma, " : ""));
    readings_.push_back(r);
  }
  if (readings_.size() < 2)
    throw InputError(fmt::format("--sensor {}: fewer than two readings", file.string()));
}

void SensorFile::fill(ForceRun* run) const {
  const bool has_runs = readings_.front().run > 0;
  for (JudgedSample& s : run->record) {
    Reading at;
    at.run = has_runs ? run->order : 0;
    at.time = has_runs ? s.time : run->begin + s.time;
    auto after = std::lower_bound(readings_.begin(), readings_.end(), at,
                                  [](const Reading& a, const Reading& b) { return a.before(b); });
    // Beyond a run's readings the nearest one of them holds; a run without any has no force.
    const auto first = readings_.begin();
    if (after != first && (after == readings_.end() || after->run != at.run)) --after;
    if (after->run != at.run) {
      s.force = std::nan("");
      continue;
    }
    const auto before = after == first || (after - 1)->run != at.run ? after : after - 1;
    const double span = after->time - before->time;
    const double share = span > 0.0 ? std::clamp((at.time - before->time) / span, 0.0, 1.0) : 0.0;
    s.force = before->force + share * (after->force - before->force);
  }
}

CrispLaw::CrispLaw(const JointVector& q_0, const CrispGains& gains)
    : gains_(gains), q_0_(q_0), tau_(JointVector::Zero(q_0.size())) {}

const JointVector& CrispLaw::step(const ArmTerms& arm, const TipReference& reference,
                                  double press) noexcept {
  if (!begun_) R_WD_ = arm.X_WE.R;
  R_WD_ = turn_between(R_WD_.col(2), -reference.n_WD) * R_WD_;
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(R_WD_ * arm.X_WE.R.transpose()));
  const auto clipped = [](const Eigen::Vector3d& x, double most) {
    return Eigen::Vector3d(x.cwiseMax(-most).cwiseMin(most));
  };
  Vector6 F;
  F << gains_.stiffness * clipped(reference.p_WD - arm.X_WE.p, gains_.clip) -
           gains_.damping * arm.V_WE.head<3>() - press * reference.n_WD,
      gains_.rotational_stiffness * clipped(turn.angle() * turn.axis(), gains_.rotational_clip) -
          gains_.rotational_damping * arm.V_WE.tail<3>();
  const JointVector wish =
      gains_.null_stiffness * (q_0_ - arm.q) - 2.0 * std::sqrt(gains_.null_stiffness) * arm.v;
  const Vector6 tip_wish = arm.J * wish;
  const Matrix6 JJt = arm.J * arm.J.transpose();
  const JointVector tau = arm.J.transpose() * F + wish -
                          arm.J.transpose() * JJt.ldlt().solve(tip_wish) + arm.Cv + arm.g;
  if (!begun_) tau_ = tau;
  begun_ = true;
  tau_ += (tau - tau_).cwiseMax(-gains_.max_delta_tau).cwiseMin(gains_.max_delta_tau);
  return tau_;
}

FeedforwardLaw::FeedforwardLaw(const JointVector& q_0, const FeedforwardGains& gains)
    : gains_(gains), q_0_(q_0), tau_(JointVector::Zero(q_0.size())) {}

const JointVector& FeedforwardLaw::step(const ArmTerms& arm, const TipReference& reference,
                                        double press) noexcept {
  space_.update(arm);
  const Eigen::Matrix3d K_linear = gains_.stiffness * Eigen::Matrix3d::Identity(),
                        K_angular = gains_.rotational_stiffness * Eigen::Matrix3d::Identity();
  damping_.design(space_.inverse_inertia_factor(), K_linear, K_angular, gains_.damping_ratio);
  Vector6 V_d, Vdot_d, Ke;
  V_d << reference.v_WD, reference.w_WD;
  Vdot_d << reference.a_WD, reference.alpha_WD;
  Ke << gains_.stiffness * (reference.p_WD - arm.X_WE.p),
      gains_.rotational_stiffness *
          smallest_rotation(arm.X_WE.R.col(2), Eigen::Vector3d(-reference.n_WD));
  Vector6 F = space_.inertia() * (Vdot_d - arm.Jdot_v) + space_.project_to_tip(arm.Cv) +
              damping_.apply(space_.inertia_factor(), V_d - arm.V_WE) + Ke;
  F.head<3>() -= press * reference.n_WD;
  const JointVector D_null =
      1.4 * (gains_.null_stiffness * arm.M.diagonal()).cwiseSqrt();  // ζ = 0.7
  const JointVector wish = gains_.null_stiffness * (q_0_ - arm.q) - D_null.cwiseProduct(arm.v);
  tau_ = arm.J.transpose() * (F - space_.project_to_tip(wish)) + wish + arm.g;
  return tau_;
}

}  // namespace impedraw

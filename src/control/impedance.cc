#include "impedraw/control/impedance.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace impedraw {

namespace {

constexpr double kSelfMotionSpeed = 1.0;  // of the fastest joint; at twice that, no pull [rad/s]
// From here on the self-motion is damped more, at twice that 1 + kMoreDamping times as much.
constexpr double kCalmSpeed = 0.7;  // of the fastest joint [rad/s]
constexpr double kMoreDamping = 12.0;
constexpr double kAlong = 0.3;        // cosine between the pull and the motion at which it is faded
constexpr double kHeadingRate = 2.0;  // of the pen, at the end of a joint's range [rad/s]
constexpr double kSlow = 0.15;        // of the tip [m/s] and its turn [rad/s]: joints are slow, too
constexpr double kHoldBack = 20.0;
// A joint comes to rest kShortOfEnd before the end of its range, at kStopRate, and creeps on
// [rad], [1/s], [rad/s].
constexpr double kShortOfEnd = 0.015, kStopRate = 8.0, kCreep = 5e-3;
constexpr double kNearEnd = 0.06;      // [rad]
constexpr double kRiseRate = 80.0;     // of what the tip's motion tells of the surface's [1/s]
constexpr double kFastestRise = 0.2;   // [m/s]
constexpr double kWeightShare = 0.12;  // of a joint's weight torque: what wrong masses may add to r

// A thin body has two sides a few millimetres apart. Of points of both the estimate lies between
// them, and faces the side that the tip is on: within the body away from the plan.
SurfaceEstimate on_planned_side(const SurfaceEstimate& surface, const Eigen::Vector3d& n_plan) {
  constexpr double kAway = -0.5;  // cosine
  SurfaceEstimate seen = surface;
  if (seen.status == SurfaceStatus::ok && seen.n_W.dot(n_plan) < kAway) {
    seen.n_W = -seen.n_W;
    seen.distance = -seen.distance;
  }
  return seen;
}

}  // namespace

ImpedanceController::ImpedanceController(const ImpedanceSettings& settings, int joints)
    : settings_((settings.validate(joints), settings.completed(joints))),
      K_damping_(settings.damping_stiffness()),
      shaped_(settings.inertia == InertiaShaping::shaped),
      measured_(settings.wrench == WrenchFeedback::measured),
      observed_(measured_ && settings.observer.enabled),
      scale_(settings.inertia == InertiaShaping::scaled ? settings.inertia_scale : 1.0),
      side_force_(std::tan(settings.friction.normal_error_deg * std::numbers::pi / 180.0)),
      q_0_(settings_.null_space.q_0),
      null_stiffness_(settings_.null_space.stiffness),
      lower_(settings_.joint_range.lower),
      upper_(settings_.joint_range.upper),
      yield_limit_(Eigen::Map<const Eigen::VectorXd>(
          settings_.observer.yield_limit.data(),
          static_cast<Eigen::Index>(settings_.observer.yield_limit.size()))),
      space_(settings.operational_space),
      observer_(settings.observer, joints, settings.timing.dt,
                std::max(0.0, settings.timing.wrench_delay - settings.timing.dt -
                                  settings.timing.velocity_age),
                settings.timing.torque_delay() + settings.timing.velocity_age),
      limits_(settings_.limits.torque, settings_.limits.torque_rate, settings.timing.dt),
      tracker_(settings.surface.normal_bandwidth, settings.timing.dt),
      felt_(settings.felt_normal, settings.timing.dt),
      contact_(settings.contact, settings.timing.dt) {
  if (shaped_)
    shaped_damping_ = diagonal_damping(K_damping_, settings.shaped_inertia, settings.damping_ratio);
  out_.tau = behind_ = JointVector::Zero(joints);
  out_.terms.setZero(joints, kTorqueTerms);
}

void ImpedanceController::retune(const TipGain& stiffness, double normal_force) {
  ImpedanceSettings changed = settings_;
  changed.stiffness = stiffness;
  changed.normal_force = normal_force;
  changed.validate(static_cast<int>(out_.tau.size()));
  settings_.stiffness = stiffness;
  settings_.normal_force = normal_force;
  K_damping_ = settings_.damping_stiffness();
  if (shaped_)
    shaped_damping_ =
        diagonal_damping(K_damping_, settings_.shaped_inertia, settings_.damping_ratio);
}

const ImpedanceTorque& ImpedanceController::step(const ArmTerms& arm, const TipReference& reference,
                                                 const SurfaceEstimate& perceived,
                                                 const Wrench& F_given, const InputAges& ages,
                                                 const FrameMotion* carrier) noexcept {
  const bool was_limited = out_.status.torque_limited;
  carrier_ = carrier;
  braked_ = false;
  out_.status = input_status(arm, reference, perceived, F_given, ages);
  if (out_.status.bad_input || out_.status.stale_state) return safe_torque();
  const SurfaceEstimate surface = on_planned_side(perceived, reference.n_WD);
  const bool has_wrench = measured_ && !out_.status.stale_wrench;
  const Wrench F_ext = has_wrench ? F_given : Wrench(Wrench::Zero());

  out_.status.near_singular = !space_.update(arm);  // Λ, J̄
  update_mode(reference, surface, F_ext);
  update_rise(arm);
  update_felt_normal(arm, F_ext);
  if (!was_limited) update_force_integral(F_ext);
  update_damping();  // B

  // Reference motion, and the force on M_d apart from push and wrench
  ReferenceMotion desired = on_surface_ ? reference_on_surface(arm, reference, surface)
                                        : reference_on_plan(arm, reference);
  const Vector6 F_impedance = handed_over(spring_and_damper(arm, &desired), desired.push);

  // F_act (10)–(11): Λ times an acceleration, Λ M_d⁻¹ times a force
  TaskTerms F_act;
  F_act.col(kFeedforward) = desired.Vdot_d;
  F_act.col(kImpedance) = F_impedance;
  F_act.col(kPush) = desired.push;
  F_act.col(kWrench) = F_ext - tip_contact(arm, F_ext);
  F_act.col(kVelocityProduct) = -arm.Jdot_v;
  apply_inertia(&F_act);
  F_act.col(kVelocityProduct) += space_.project_to_tip(arm.Cv);
  F_act.col(kWrench) -= F_ext;
  F_act.col(kFeedforward).head<3>() += foreseen_friction(arm, desired.V_d);

  // τ (12), (14)–(17)
  const JointVector tau_null = null_space_torque(arm);
  out_.terms.leftCols<kVelocityProduct + 1>() = arm.J.transpose().lazyProduct(F_act);
  out_.terms.col(kNullSpace) =
      tau_null - arm.J.transpose().lazyProduct(space_.project_to_tip(tau_null));
  out_.terms.col(kGravity) = arm.g;
  if (observed_) out_.terms.col(kDisturbance) = -disturbance(arm, F_ext);

  // Finite inputs can still be invalid: M may not be positive definite.
  out_.status.bad_input = !std::isfinite(out_.terms.sum());
  if (out_.status.bad_input) return safe_torque();
  apply_limits(arm);
  return out_;
}

// D ṽ + K ∫ṽ dt, ṽ: what v lacks of v_D. D and K are diagonal, so that no error of M adds energy.
JointVector ImpedanceController::brake_torque(const ArmTerms& arm,
                                              const JointVector& lack) const noexcept {
  constexpr double kFast = 2.0;   // a speed from which to brake [rad/s]
  constexpr double kShare = 0.3;  // of the braking time in which the torque may build up
  const double most = bearable_rate();
  const Eigen::VectorXd& rate = settings_.limits.torque_rate;
  JointVector tau(lack.size());
  for (Eigen::Index j = 0; j < tau.size(); ++j) {
    const double M = arm.M(j, j);
    double D = most / space_.acceleration(JointVector::Unit(tau.size(), j))[j];
    if (rate.size() > 0) D = std::min(D, std::sqrt(kShare * rate[j] / kFast * M));
    tau[j] = D * lack[j] + 0.25 * D * D / M * behind_[j];
  }
  return tau;
}

const ImpedanceTorque& ImpedanceController::brake(const ArmTerms& arm,
                                                  const Eigen::Vector3d& v_WD) noexcept {
  constexpr double kFurthest = 0.5;  // that a joint may be behind [rad]
  forget();
  out_.status = {};
  out_.status.bad_input = !arm.v.allFinite() || !arm.M.allFinite() || !arm.g.allFinite();
  if (out_.status.bad_input) return safe_torque();
  out_.mode = ContactMode::free;
  out_.push = 0.0;
  out_.p_WD = arm.X_WE.p;
  out_.n_WD = out_.axis_WD = -arm.X_WE.R.col(2);
  out_.terms.setZero();
  out_.status.near_singular = !space_.update(arm);
  Vector6 V_D;
  V_D << v_WD, Eigen::Vector3d::Zero();
  const JointVector v_D =
      space_.acceleration(arm.J.transpose().lazyProduct(Vector6(space_.inertia() * V_D)));
  if (!braked_) behind_.setZero();
  braked_ = true;
  behind_ += settings_.timing.dt * (v_D - arm.v);
  behind_ = behind_.cwiseMax(-kFurthest).cwiseMin(kFurthest);
  out_.terms.col(kImpedance) = brake_torque(arm, v_D - arm.v);
  out_.terms.col(kGravity) = arm.g;
  out_.status.bad_input = !std::isfinite(out_.terms.sum()) || !space_.inertia().allFinite();
  if (out_.status.bad_input) return safe_torque();
  const LimitedTorque limited = limits_.nearest(out_.terms.rowwise().sum(), arm.M);
  out_.tau = limited.tau;
  out_.status.torque_limited = limited.limited;
  return out_;
}

void ImpedanceController::reset() noexcept {
  forget();
  limits_.reset();
  force_from_zero_ = false;
}

// Clears state that may be invalid after a loss of control. Keeps the last torque for the rate
// limit.
void ImpedanceController::forget() noexcept {
  contact_.reset();
  observer_.reset();
  last_mode_ = ContactMode::free;
  on_surface_ = false;
  felt_.reset();
  force_integral_ = rise_ = 0.0;
  carried_force_.setZero();
  last_force_.setZero();
  force_from_zero_ = true;
}

// Checks age, size and finiteness of the inputs.
ControlStatus ImpedanceController::input_status(const ArmTerms& arm, const TipReference& reference,
                                                const SurfaceEstimate& surface, const Wrench& F_ext,
                                                const InputAges& ages) const noexcept {
  ControlStatus status;
  status.stale_state = !(ages.state <= settings_.timing.max_state_age);
  status.stale_wrench = measured_ && !(ages.wrench <= settings_.timing.max_wrench_age);
  status.bad_input = true;
  const auto unit = [](const Eigen::Vector3d& n) { return std::abs(n.squaredNorm() - 1.0) < 1e-6; };
  const auto n = out_.tau.size();
  if (arm.q.size() != n || arm.v.size() != n || arm.M.rows() != n || arm.M.cols() != n ||
      arm.Cv.size() != n || arm.g.size() != n || arm.J.cols() != n || !unit(reference.n_WD))
    return status;
  double sum = arm.q.sum() + arm.v.sum() + arm.M.sum() + arm.Cv.sum() + arm.g.sum() + arm.J.sum() +
               arm.Jdot_v.sum() + arm.X_WE.p.sum() + arm.X_WE.R.sum() + arm.V_WE.sum() +
               reference.p_WD.sum() + reference.v_WD.sum() + reference.a_WD.sum() +
               reference.n_WD.sum() + reference.w_WD.sum() + reference.alpha_WD.sum();
  if (surface.status == SurfaceStatus::ok) {
    if (!unit(surface.n_W)) return status;
    sum += surface.n_W.sum() + surface.distance;
  }
  if (measured_ && !status.stale_wrench) sum += F_ext.sum();
  status.bad_input = !std::isfinite(sum);
  return status;
}

// Returns the last gravity torque, which holds the arm still. No damping: the velocity may be
// invalid.
const ImpedanceTorque& ImpedanceController::safe_torque() noexcept {
  out_.terms.leftCols<kGravity>().setZero();
  out_.terms.col(kDisturbance).setZero();
  const LimitedTorque limited = limits_.clip(out_.terms.col(kGravity));
  out_.tau = limited.tau;
  out_.status.torque_limited = limited.limited;
  out_.mode = ContactMode::free;
  out_.push = 0.0;
  out_.task_share = 0.0;
  forget();
  return out_;
}

void ImpedanceController::update_mode(const TipReference& reference, const SurfaceEstimate& surface,
                                      const Wrench& F_ext) noexcept {
  const bool known = surface.status == SurfaceStatus::ok;
  ContactEvidence evidence;
  evidence.pen_down = reference.pen_down;
  evidence.surface_known = known;
  evidence.distance = known ? surface.distance : 0.0;
  evidence.wrench_known = measured_;
  evidence.wrench_lost = out_.status.stale_wrench;
  evidence.normal_force =
      evidence.wrench_known ? F_ext.head<3>().dot(on_surface_ ? tracker_.n() : surface.n_W) : 0.0;
  evidence.approach_gap = surface.distance - approach_distance_;
  const ContactMode before = contact_.mode();
  const ContactMode mode = contact_.next(evidence);

  const bool on_surface = mode == ContactMode::approach || mode == ContactMode::contact;
  if (on_surface && !on_surface_) tracker_.reset(reference.n_WD, reference.w_WD);
  if (on_surface) known ? tracker_.update(surface.n_W, reference.alpha_WD) : tracker_.coast();
  if (mode == ContactMode::approach && before != mode)
    approach_distance_ = known ? surface.distance : 0.0;
  on_surface_ = on_surface;
  out_.mode = mode;
  out_.n_WD = on_surface ? tracker_.n() : reference.n_WD;
  out_.status.surface_lost = reference.pen_down && !known && surface.status != SurfaceStatus::none;
}

void ImpedanceController::update_force_integral(const Wrench& F_ext) noexcept {
  const ForceIntegralSettings& s = settings_.force_integral;
  if (!s.enabled || !measured_) return;
  if (out_.mode != ContactMode::contact) {
    force_integral_ = 0.0;  // its effect decays with the force carried over at the switch
    return;
  }
  const Eigen::Vector3d& n = out_.n_WD;
  // while the push builds up, its present value
  const double asked = settings_.normal_force * n.dot(n_C_) - n.dot(carried_force_.head<3>());
  const double error = asked - n.dot(F_ext.head<3>());
  force_integral_ =
      std::clamp(force_integral_ + s.rate * settings_.timing.dt * error, -s.limit, s.limit);
}

// In contact the tip moves as the surface does: what its velocity along n has beyond the carrier's
// is learned, slowly enough that the damping along n stays.
void ImpedanceController::update_rise(const ArmTerms& arm) noexcept {
  if (!carrier_ || out_.mode != ContactMode::contact) {
    rise_ = out_.rise = 0.0;  // its effect decays with the force carried over at the switch
    return;
  }
  const Eigen::Vector3d v = arm.V_WE.head<3>() - carrier_velocity(arm.X_WE.p);
  rise_ += kRiseRate * settings_.timing.dt * (out_.n_WD.dot(v) - rise_);
  rise_ = std::clamp(rise_, -kFastestRise, kFastestRise);
  out_.rise = rise_;
}

void ImpedanceController::update_felt_normal(const ArmTerms& arm, const Wrench& F_ext) noexcept {
  if (!measured_ || !felt_.in_use() || out_.mode != ContactMode::contact) {
    felt_.reset();
    n_C_ = out_.n_WD;
    return;
  }
  out_.n_WD = felt_.corrected(tracker_.n());  // from the steps before
  felt_.update(out_.n_WD, F_ext.head<3>(), slip(arm), settings_.friction.coefficient,
               0.2 * settings_.normal_force);
  out_.n_WD = felt_.corrected(tracker_.n());
  n_C_ = felt_.seen_from(out_.n_WD);
}

// Of the tip along the surface: its direction, shorter where it is too slow to have one.
Eigen::Vector3d ImpedanceController::slip(const ArmTerms& arm) const noexcept {
  const Eigen::Vector3d& n = out_.n_WD;
  const Eigen::Vector3d v = arm.V_WE.head<3>() - carrier_velocity(arm.X_WE.p);
  const Eigen::Vector3d v_t = v - n * n.dot(v);
  const double fade = settings_.friction.fade_speed;
  return v_t / std::sqrt(v_t.squaredNorm() + fade * fade);
}

// Updates B for this posture, if the desired inertia depends on posture.
void ImpedanceController::update_damping() noexcept {
  if (shaped_) return;
  const Eigen::Vector3d& n = out_.n_WD;
  modal_damping_.design(space_.inverse_inertia_factor(), K_damping_.linear.matrix(n),
                        K_damping_.angular.matrix(n), settings_.damping_ratio);
  const double rate = modal_damping_.largest_rate() / std::sqrt(scale_);
  out_.status.damping_limit = rate * settings_.timing.damping_delay() >= kDampingLimit;
}

// B V. If M_d = c Λ, C and A of damping.h are 1/c of those for M_d = Λ.
Vector6 ImpedanceController::damp(const Vector6& V) const noexcept {
  if (shaped_) return shaped_damping_.apply(out_.n_WD, V);
  return std::sqrt(scale_) * modal_damping_.apply(space_.inertia_factor(), V);
}

// How deep a joint is within the margins of its lower and its upper limit: 0 outside, 1 at it.
std::pair<double, double> ImpedanceController::into_margins(const JointVector& q,
                                                            int j) const noexcept {
  const double margin = settings_.joint_range.margin;
  const double above = margin - (q[j] - lower_[j]), below = margin - (upper_[j] - q[j]);
  if (above <= 0.0 && below <= 0.0) return {0.0, 0.0};
  return {std::max(0.0, above) / margin, std::max(0.0, below) / margin};
}

// Of the pen about its axis, away from the ends of the joints' ranges [rad/s]. Null-space torque
// cannot do it: on closed lines about a hill the pen's heading, and the last joint with it, turns
// on and on.
double ImpedanceController::heading_rate(const ArmTerms& arm) const noexcept {
  JointVector away = JointVector::Zero(arm.q.size());
  for (int j = 0; j < lower_.size(); ++j) {
    const auto [above, below] = into_margins(arm.q, j);
    away[j] = above * above - below * below;
  }
  if (away.isZero()) return 0.0;
  Vector6 spin = Vector6::Zero();
  spin.tail<3>() = arm.X_WE.R.col(2);
  const JointVector by_spin = space_.joint_speed(spin);
  return kHeadingRate * std::clamp(away.dot(by_spin) / by_spin.cwiseAbs().maxCoeff(), -1.0, 1.0);
}

// Of joint j in the direction of v: its limit, and less before the end of its range, so that it
// comes to rest there [rad/s].
double ImpedanceController::most_joint_speed(const ArmTerms& arm, Eigen::Index j,
                                             double v) const noexcept {
  if (lower_.size() == 0) return settings_.limits.joint_speed[j];
  const double room = v < 0.0 ? arm.q[j] - lower_[j] : upper_[j] - arm.q[j];
  return std::min(settings_.limits.joint_speed[j],
                  kCreep * std::clamp(room / kShortOfEnd, 0.0, 1.0) +
                      kStopRate * std::max(0.0, room - kShortOfEnd));
}

// Scales the turning part of V until no joint exceeds its speed limit; if that is not enough, all
// of it. The arm keeps the motion that does not move the tip: near a singular posture, what the
// elbow's asks of the wrist counts more than what the tip's does.
void ImpedanceController::keep_joint_speeds(const ArmTerms& arm, Vector6* V) const noexcept {
  const Eigen::Index n = settings_.limits.joint_speed.size();
  if (n == 0) return;
  TwoVelocities apart = TwoVelocities::Zero();  // the turn alone; the rest, less what the tip does
  apart.col(0).tail<3>() = V->tail<3>();
  apart.col(1).head<3>() = V->head<3>();
  apart.col(1) -= arm.V_WE;
  const TwoJointSpeeds change = space_.joint_speeds(apart);
  const auto by_turn = change.col(0);
  const JointVector without_turn = arm.v + change.col(1);
  // the largest share of `by` that keeps joint j within its limit
  const auto share = [&](Eigen::Index j, double rest, double by) {
    const double way = std::copysign(1.0, by), most = most_joint_speed(arm, j, by);
    if (by == 0.0 || way * rest + std::abs(by) <= most) return 1.0;
    return std::max(0.0, (most - way * rest) / std::abs(by));
  };
  double turn = 1.0, both = 1.0;
  for (Eigen::Index j = 0; j < n; ++j) turn = std::min(turn, share(j, without_turn[j], by_turn[j]));
  V->tail<3>() *= turn;
  const JointVector v = without_turn + turn * by_turn;
  bool fast = false;
  for (Eigen::Index j = 0; j < n; ++j) fast |= std::abs(v[j]) > most_joint_speed(arm, j, v[j]);
  if (!fast) return;
  const JointVector by_tip = space_.joint_speed(*V);
  for (Eigen::Index j = 0; j < n; ++j) both = std::min(both, share(j, v[j] - by_tip[j], by_tip[j]));
  *V *= both;
}

// B (V_d − V) + K e. If the steady-state speed V_d + B⁻¹ K e exceeds a limit, it is scaled to the
// limit, and the part of V̇_d that accelerates the tip along it is removed, by degrees: torque would
// step at a limit that comes and goes.
Vector6 ImpedanceController::spring_and_damper(const ArmTerms& arm,
                                               ReferenceMotion* desired) noexcept {
  const Vector6& V = arm.V_WE;
  desired->V_d.tail<3>() += heading_rate(arm) * arm.X_WE.R.col(2);
  const double limit = settings_.limits.tip_speed, turn_limit = settings_.limits.turn_speed;
  // Smaller ones stay far below any limit: skip the solves.
  const bool joints = settings_.limits.joint_speed.size() > 0;
  const bool at_end = joints && lower_.size() > 0 &&
                      std::min((arm.q - lower_).minCoeff(), (upper_ - arm.q).minCoeff()) < kNearEnd;
  const double slow = std::min(joints ? kSlow : 1e9, 0.8 * limit),
               turns_slowly = std::min(joints ? kSlow : 1e9, 0.8 * turn_limit);
  const double small_pull = 2e-3 * settings_.stiffness.linear.tangent;
  const double small_turn = (joints ? 5e-3 : 2e-2) * settings_.stiffness.angular.tangent;
  const Vector6 &V_d = desired->V_d, &Ke = desired->Ke;
  if (at_end || V_d.head<3>().squaredNorm() > slow * slow ||
      V_d.tail<3>().squaredNorm() > turns_slowly * turns_slowly ||
      Ke.head<3>().squaredNorm() > small_pull * small_pull ||
      Ke.tail<3>().squaredNorm() > small_turn * small_turn) {
    const Vector6 follow = shaped_
                               ? shaped_damping_.inverse().apply(out_.n_WD, Ke)
                               : Vector6(modal_damping_.solve(space_.inverse_inertia_factor(), Ke) /
                                         std::sqrt(scale_));
    Vector6 V_end = V_d + follow;
    const double speed = V_end.head<3>().norm(), turn = V_end.tail<3>().norm();
    // scale both parts: a coupled inertia would turn the remaining rotation into speed
    V_end *= std::min(limit / std::max(speed, limit), turn_limit / std::max(turn, turn_limit));
    keep_joint_speeds(arm, &V_end);
    const double slower = 1.0 - V_end.head<3>().norm() / std::max(speed, 1e-9),
                 turns_slower = 1.0 - V_end.tail<3>().norm() / std::max(turn, 1e-9);
    if (slower > 0.0 || turns_slower > 0.0) {
      out_.status.speed_limited = true;
      const auto hold_back = [](double by, auto a, const Eigen::Vector3d& along) {
        a -= std::min(1.0, kHoldBack * by) * std::max(0.0, a.dot(along)) * along;
      };
      hold_back(slower, desired->Vdot_d.head<3>(), V_end.head<3>().normalized());
      hold_back(turns_slower, desired->Vdot_d.tail<3>(), V_end.tail<3>().normalized());
      return damp(V_end - V);
    }
  }
  return damp(V_d - V) + Ke;
}

// Returns `force` plus the carried force, which cancels the jump at a mode switch and decays.
Vector6 ImpedanceController::handed_over(const Vector6& force, const Vector6& push) noexcept {
  if (out_.mode != last_mode_ || force_from_zero_) carried_force_ = last_force_ - (force + push);
  force_from_zero_ = false;
  last_mode_ = out_.mode;
  last_force_ = force + push + carried_force_;
  const Vector6 continuous = force + carried_force_;
  carried_force_ *= std::max(0.0, 1.0 - settings_.timing.dt / settings_.switch_time);
  return continuous;
}

// The part of F_ext that contact at the tip can explain: Coulomb friction along −v_t, up to μ̂ f_n,
// and what a wrong normal makes of f_n, up to tan(δ) f_n across n.
Wrench ImpedanceController::tip_contact(const ArmTerms& arm, const Wrench& F_ext) const noexcept {
  Wrench contact = Wrench::Zero();
  const FrictionSettings& s = settings_.friction;
  if (!measured_ || out_.mode != ContactMode::contact) return contact;
  const Eigen::Vector3d& n = out_.n_WD;
  const double f_n = std::max(0.0, n.dot(F_ext.head<3>()));
  const Eigen::Vector3d slip = this->slip(arm);
  const Eigen::Vector3d f_t = F_ext.head<3>() - n * n.dot(F_ext.head<3>());
  const Eigen::Vector3d friction = friction_in(f_t, slip, s.coefficient * f_n);
  // At rest the spring's own pull would be taken for it.
  const Eigen::Vector3d aside = slip.norm() * (f_t - friction);
  const double most = side_force_ * f_n;
  contact.head<3>() = friction + aside * (most / std::max(most, aside.norm() + 1e-9));
  return contact;
}

// Feedforward force against friction along the stroke, without a measured wrench.
Eigen::Vector3d ImpedanceController::foreseen_friction(const ArmTerms& arm,
                                                       const Vector6& V_d) const noexcept {
  const FrictionSettings& s = settings_.friction;
  if (measured_ || s.feedforward <= 0.0 || out_.mode != ContactMode::contact)
    return Eigen::Vector3d::Zero();
  const Eigen::Vector3d v_d = V_d.head<3>() - carrier_velocity(arm.X_WE.p);
  const double speed = std::sqrt(v_d.squaredNorm() + s.fade_speed * s.fade_speed);
  return s.feedforward * out_.push / speed * v_d;
}

// Multiplies accelerations by Λ and forces by Λ M_d⁻¹, which is 1/c if M_d = c Λ.
void ImpedanceController::apply_inertia(TaskTerms* F) const noexcept {
  const Matrix6& Lambda = space_.inertia();
  if (shaped_) {
    const TipGain mobility = settings_.shaped_inertia.inverse();
    for (const int force : {kImpedance, kPush, kWrench})
      F->col(force) = mobility.apply(out_.n_WD, F->col(force));
    *F = (Lambda * *F).eval();
  } else {
    for (const int acceleration : {kFeedforward, kVelocityProduct})
      F->col(acceleration) = (Lambda * F->col(acceleration)).eval();
    for (const int force : {kImpedance, kPush, kWrench}) F->col(force) /= scale_;
  }
}

// K_q (q_0 − q) − D_q v + τ_limit, D_q = 2 ζ √(K_q diag(M)). (14)–(15)
JointVector ImpedanceController::null_space_torque(const ArmTerms& arm) noexcept {
  const JointVector D_q = 2.0 * settings_.null_space.damping_ratio *
                          null_stiffness_.cwiseProduct(arm.M.diagonal()).cwiseSqrt();
  // Past a singular posture, which has held it, the arm would swing back to q_0 at several times
  // its joints' speed limits: the pull fades while they are fast.
  const JointVector pull = null_stiffness_.cwiseProduct(q_0_ - arm.q);
  const double speed = arm.v.cwiseAbs().maxCoeff();
  const double fast = speed / kSelfMotionSpeed - 1.0;
  // By degrees from where it neither speeds the arm up nor slows it down, or it would come and go.
  const double along = pull.dot(arm.v) / (kAlong * pull.norm() * arm.v.norm() + 1e-12);
  const double share = 1.0 - std::clamp(fast, 0.0, 1.0) * std::clamp(along, 0.0, 1.0);
  double damping = 1.0 + kMoreDamping * std::clamp(speed / kCalmSpeed - 1.0, 0.0, 1.0);
  if (damping > 1.0) {
    const JointVector self = arm.v - space_.joint_speed(arm.V_WE);
    const double rate = self.dot(D_q.cwiseProduct(self)) / self.dot(arm.M * self);
    if (rate > 0.0) damping = std::clamp(bearable_rate() / rate, 1.0, damping);
  }
  return share * pull - damping * D_q.cwiseProduct(arm.v) + limit_repulsion(arm.q);
}

// τ_limit
JointVector ImpedanceController::limit_repulsion(const JointVector& q) noexcept {
  JointVector tau = JointVector::Zero(q.size());
  for (int j = 0; j < lower_.size(); ++j) {
    const auto [above, below] = into_margins(q, j);
    if (above == 0.0 && below == 0.0) continue;
    out_.status.joint_limit = true;
    const double into = std::max(above, below);
    tau[j] = (above > below ? 1.0 : -1.0) * settings_.joint_range.torque * into * into;
  }
  return tau;
}

// r_y. Held constant while there is no wrench to subtract.
JointVector ImpedanceController::disturbance(const ArmTerms& arm, const Wrench& F_ext) noexcept {
  if (out_.status.stale_wrench)
    observer_.pause();
  else
    observer_.update(arm, F_ext);
  const JointVector& r = observer_.disturbance();
  if (yield_limit_.size() == 0) return r;
  const JointVector most = yield_limit_ + kWeightShare * arm.g.cwiseAbs();
  if ((r.cwiseAbs() - most).maxCoeff() <= 0.0) return r;
  const JointVector within = r.cwiseMin(most).cwiseMax(-most);
  return within + arm.J.transpose().lazyProduct(space_.project_to_tip(r - within));
}

// Damps each joint that is faster than its limit, as much as the loop bears: near a singular
// posture the tip's speed changes what it asks of them faster than they can follow. It only takes
// energy.
JointVector ImpedanceController::too_fast(const ArmTerms& arm) noexcept {
  JointVector tau = JointVector::Zero(arm.v.size());
  for (Eigen::Index j = 0; j < settings_.limits.joint_speed.size(); ++j) {
    const double over = std::abs(arm.v[j]) - most_joint_speed(arm, j, arm.v[j]);
    if (over <= 0.0) continue;
    out_.status.speed_limited = true;
    const double lightness = space_.acceleration(JointVector::Unit(tau.size(), j))[j];
    tau[j] = -std::copysign(bearable_rate() * over / lightness, arm.v[j]);
  }
  return tau;
}

void ImpedanceController::apply_limits(const ArmTerms& arm) noexcept {
  const LimitedTorque limited =
      limits_.apply(out_.terms.rightCols<2>().rowwise().sum(),
                    out_.terms.leftCols<kNullSpace>().rowwise().sum() + too_fast(arm),
                    out_.terms.col(kNullSpace), arm, space_);
  out_.tau = limited.tau;
  out_.task_share = limited.task_share;
  out_.status.torque_limited = limited.limited;
  if (observed_ && !out_.status.stale_wrench) observer_.commanded(out_.tau);
}

}  // namespace impedraw

#include "control/impedance.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/errors.h"
#include "control/normal_loop.h"

namespace impedraw {

namespace {

const Eigen::Vector3d kDrawingAxis = Eigen::Vector3d::UnitZ();

Vector6 stacked(const Eigen::Vector3d& linear, const Eigen::Vector3d& angular) {
  Vector6 x;
  x << linear, angular;
  return x;
}

Vector6 apply(const TipGain& gain, const Eigen::Vector3d& n, const Vector6& x) {
  return stacked(gain.linear.apply(n, x.head<3>()), gain.angular.apply(n, x.tail<3>()));
}

TipGain inverse(const TipGain& g) {
  return {{1.0 / g.linear.tangent, 1.0 / g.linear.normal}, {1.0 / g.angular.tangent, 1.0 / g.angular.normal}};
}

// K' of control.md: where a stiffness is zero, the reference sizes the damping.
TipGain with_reference(const TipGain& k, const TipGain& reference) {
  const auto pick = [](double value, double fallback) { return value > 0.0 ? value : fallback; };
  return {{pick(k.linear.tangent, reference.linear.tangent), pick(k.linear.normal, reference.linear.normal)},
          {pick(k.angular.tangent, reference.angular.tangent), pick(k.angular.normal, reference.angular.normal)}};
}

}  // namespace

ImpedanceController::ImpedanceController(const ImpedanceSettings& settings, int joints)
    : settings_(settings), q_0_(settings.q_0), null_stiffness_(settings.null_stiffness), torque_limit_(settings.torque_limit),
      space_(settings.operational_space), tracker_(settings.normal_bandwidth, settings.dt), contact_(settings.contact, settings.dt) {
  const auto check_size = [&](const char* name, const Eigen::VectorXd& x) {
    if (x.size() != joints)
      throw InputError(std::string(name) + " has " + std::to_string(x.size()) + " entries, the arm " + std::to_string(joints) + " joints");
  };
  check_size("q_0", settings.q_0);
  check_size("null_stiffness", settings.null_stiffness);
  check_size("torque_limit", settings.torque_limit);
  // Across the normal the reference is what holds in contact; the stiffness of free motion must not change the damping at a switch.
  settings_.reference_stiffness = with_reference(settings.stiffness, settings.reference_stiffness);
  if (settings.inertia == InertiaShaping::shaped) {
    if (settings.wrench == WrenchFeedback::none)
      throw InputError(
          "inertia 'shaped' needs a measured wrench; without one the wanted inertia must be 'natural' or the force is not the push");
    shaped_damping_ = diagonal_damping(settings_.reference_stiffness, settings.shaped_inertia, settings.damping_ratio);
    check_damping_rates(shaped_damping_, settings.shaped_inertia, settings.dt + settings.delay);
    check_normal_loop(settings.shaped_inertia.linear.normal, shaped_damping_.linear.normal, settings);
  }
  out_.tau = JointVector::Zero(joints);
  out_.terms.setZero(joints, kTorqueTerms);
}

void ImpedanceController::reset() noexcept {
  contact_.reset();
  last_mode_ = ContactMode::free;
  on_surface_ = false;
  carried_force_.setZero();
  last_force_.setZero();
}

bool ImpedanceController::finite(const ArmTerms& arm, const TipGoal& goal, const SurfaceEstimate& surface,
                                 const Wrench& F_ext) const noexcept {
  double sum = arm.q.sum() + arm.v.sum() + arm.M.sum() + arm.Cv.sum() + arm.g.sum() + arm.J.sum() + arm.Jdot_v.sum() + arm.X_WE.p.sum() +
               arm.X_WE.R.sum() + arm.V_WE.sum() + goal.p_WD.sum() + goal.v_WD.sum() + goal.a_WD.sum() + goal.n_WD.sum() + goal.w_WD.sum() +
               goal.alpha_WD.sum();
  if (surface.status == SurfaceStatus::ok) sum += surface.n_W.sum() + surface.distance;
  if (settings_.wrench == WrenchFeedback::measured) sum += F_ext.sum();
  return std::isfinite(sum);
}

const ImpedanceTorque& ImpedanceController::step(const ArmTerms& arm, const TipGoal& goal, const SurfaceEstimate& surface,
                                                 const Wrench& F_ext) noexcept {
  out_.status = {};
  if (!finite(arm, goal, surface, F_ext)) {
    // The pen rests on what holds the arm still; a velocity that may be NaN is no use for braking.
    out_.status.bad_input = true;
    out_.terms.leftCols<kTorqueTerms - 1>().setZero();
    out_.tau = out_.terms.col(kGravity);
    reset();
    out_.mode = ContactMode::free;
    return out_;
  }
  out_.status.near_singular = !space_.update(arm);
  update_mode(goal, surface, F_ext);

  const bool natural = settings_.inertia == InertiaShaping::natural;
  const Eigen::Vector3d& n = out_.n_WD;
  if (natural) {
    const TipGain& K = settings_.reference_stiffness;
    modal_damping_.design(space_.inverse_inertia_factor(), K.linear.matrix(n), K.angular.matrix(n), settings_.damping_ratio);
    out_.status.damping_limit = modal_damping_.largest_rate() * (settings_.dt + settings_.delay) >= kDampingLimit;
  }
  Wanted wanted = on_surface_ ? want_on_surface(arm, goal, surface) : want_on_plan(arm, goal);

  // What a switch would change at once is carried over and fades.
  if (out_.mode != last_mode_) carried_force_ = last_force_ - (wanted.force + wanted.push);
  last_mode_ = out_.mode;
  last_force_ = wanted.force + wanted.push + carried_force_;
  wanted.force += carried_force_;
  carried_force_ *= 1.0 - settings_.dt / settings_.switch_time;

  // F_act of (11), a column a term.
  Eigen::Matrix<double, 6, kVelocityProduct + 1> F;
  const bool measured = settings_.wrench == WrenchFeedback::measured;
  if (natural) {
    F.col(kFeedforward) = space_.inertia() * wanted.Vdot_d;
    F.col(kVelocityProduct) = -(space_.inertia() * arm.Jdot_v);
    F.col(kImpedance) = wanted.force;
    F.col(kPush) = wanted.push;
    F.col(kWrench).setZero();
    if (measured) F.col(kWrench) = -tip_friction(arm, F_ext);  // Λ M_d⁻¹ F_kept − F_ext with M_d = Λ
  } else {
    const TipGain mobility = inverse(settings_.shaped_inertia);
    F.col(kFeedforward) = wanted.Vdot_d;
    F.col(kImpedance) = apply(mobility, n, wanted.force);
    F.col(kPush) = apply(mobility, n, wanted.push);
    F.col(kWrench) = apply(mobility, n, F_ext - tip_friction(arm, F_ext));
    F.col(kVelocityProduct) = -arm.Jdot_v;
    F = (space_.inertia() * F).eval();
    F.col(kWrench) -= F_ext;
  }
  if (!measured && settings_.friction_feedforward > 0.0 && out_.mode == ContactMode::contact) {
    const Eigen::Vector3d v_d = wanted.V_d.head<3>();
    const double speed = std::sqrt(v_d.squaredNorm() + settings_.friction_speed * settings_.friction_speed);
    F.col(kFeedforward).head<3>() += settings_.friction_feedforward * out_.push / speed * v_d;
  }
  F.col(kVelocityProduct) += space_.project_to_tip(arm.Cv);

  const JointVector D_q = 2.0 * settings_.null_damping_ratio * null_stiffness_.cwiseProduct(arm.M.diagonal()).cwiseSqrt();
  const JointVector tau_null = null_stiffness_.cwiseProduct(q_0_ - arm.q) - D_q.cwiseProduct(arm.v);

  out_.terms.leftCols<kVelocityProduct + 1>() = arm.J.transpose().lazyProduct(F);
  out_.terms.col(kNullSpace) = tau_null - arm.J.transpose().lazyProduct(space_.project_to_tip(tau_null));
  out_.terms.col(kGravity) = arm.g;
  out_.tau = out_.terms.rowwise().sum();
  limit_torque();
  return out_;
}

void ImpedanceController::update_mode(const TipGoal& goal, const SurfaceEstimate& surface, const Wrench& F_ext) noexcept {
  const bool known = surface.status == SurfaceStatus::ok;
  ContactEvidence evidence;
  evidence.pen_down = goal.pen_down;
  evidence.surface_known = known;
  evidence.distance = known ? surface.distance : 0.0;
  evidence.wrench_known = settings_.wrench == WrenchFeedback::measured;
  evidence.normal_force = evidence.wrench_known ? F_ext.head<3>().dot(on_surface_ ? tracker_.n() : surface.n_W) : 0.0;
  evidence.approach_gap = surface.distance - approach_distance_;
  const ContactMode before = contact_.mode();
  const ContactMode mode = contact_.next(evidence);

  const bool on_surface = mode == ContactMode::approach || mode == ContactMode::contact;
  if (on_surface && !on_surface_) tracker_.reset(goal.n_WD, goal.w_WD);
  if (on_surface) known ? tracker_.update(surface.n_W, goal.alpha_WD) : tracker_.coast();
  if (mode == ContactMode::approach && before != mode) approach_distance_ = known ? surface.distance : 0.0;
  on_surface_ = on_surface;
  out_.mode = mode;
  out_.n_WD = on_surface ? tracker_.n() : goal.n_WD;
  out_.status.surface_lost = goal.pen_down && !known && surface.status != SurfaceStatus::none;
}

// Away from the surface: the pose of the plan, in full stiffness.
ImpedanceController::Wanted ImpedanceController::want_on_plan(const ArmTerms& arm, const TipGoal& goal) noexcept {
  Wanted w;
  Eigen::Vector3d p_WD = goal.p_WD;
  if (out_.mode == ContactMode::retreat) p_WD += settings_.retreat_height * goal.n_WD;
  out_.push = 0.0;
  out_.p_WD = p_WD;
  w.V_d = stacked(goal.v_WD, goal.w_WD);
  w.Vdot_d = stacked(goal.a_WD, goal.alpha_WD);
  const Vector6 e = stacked(p_WD - arm.X_WE.p, smallest_rotation(arm.X_WE.R.col(2), -goal.n_WD));
  w.force = damp(w.V_d - arm.V_WE) + apply(settings_.stiffness, goal.n_WD, e);
  w.push.setZero();
  return w;
}

// Approach and contact: along the tangents the plan as seen along the drawing axis, along the normal the estimated surface.
ImpedanceController::Wanted ImpedanceController::want_on_surface(const ArmTerms& arm, const TipGoal& goal,
                                                                 const SurfaceEstimate& surface) noexcept {
  const Eigen::Vector3d& n = tracker_.n();
  const Eigen::Vector3d& z = kDrawingAxis;
  const Eigen::Vector3d n_dot = tracker_.w().cross(n);
  const bool contact = out_.mode == ContactMode::contact;
  out_.push = contact ? settings_.push_force : 0.0;

  // The ink lies under the centre of the tip sphere, E sinks with the tip's give: follow the plan with the ink, not with E. The give is
  // that of the push as it builds up, or the tip would be asked aside while friction still holds it.
  const double acting_push = contact ? std::max(0.0, out_.push - n.dot(carried_force_.head<3>())) : 0.0;
  const double give = settings_.tip_stiffness > 0.0 ? acting_push / settings_.tip_stiffness : 0.0;
  const Eigen::Vector3d p_EC = give * n - settings_.tip_radius * (arm.X_WE.R.col(2) + n);
  out_.p_WD = goal.p_WD - p_EC;

  const double cosine = n.dot(z);
  const bool lifted = settings_.projection == ErrorProjection::lifted && std::abs(cosine) > settings_.min_axis_cosine;
  const Eigen::Vector3d e = out_.p_WD - arm.X_WE.p;
  const Eigen::Vector3d& u = goal.v_WD;
  Eigen::Vector3d e_t, v_t, a_t;
  if (lifted) {
    const double rise = n.dot(u) / cosine;  // what the plan's own height changes is not followed: the surface is where it is found
    e_t = e - z * (n.dot(e) / cosine);
    v_t = u - z * rise;
    a_t = goal.a_WD - z * ((n_dot.dot(u) + n.dot(goal.a_WD) - rise * n_dot.dot(z)) / cosine);
  } else {
    const auto on_page = [&z](const Eigen::Vector3d& x) -> Eigen::Vector3d { return x - z * z.dot(x); };
    e_t = on_page(e);
    e_t -= n * n.dot(e_t);
    v_t = u - n * n.dot(u);
    a_t = goal.a_WD - n * n.dot(goal.a_WD);
  }

  TipGain K = settings_.stiffness;
  Eigen::Vector3d e_n = Eigen::Vector3d::Zero();
  if (contact) {
    K.linear.normal = 0.0;
  } else {
    const bool reached_end = approach_distance_ <= -settings_.approach_overtravel;
    if (!reached_end) {
      approach_distance_ -= settings_.approach_speed * settings_.dt;
      v_t -= lifted ? Eigen::Vector3d(z * (settings_.approach_speed / cosine)) : Eigen::Vector3d(n * settings_.approach_speed);
    }
    if (surface.status == SurfaceStatus::ok) e_n = n * (approach_distance_ - surface.distance);
  }
  Wanted w;
  w.V_d = stacked(v_t, tracker_.w());
  w.Vdot_d = stacked(a_t, goal.alpha_WD - n * n.dot(goal.alpha_WD));
  w.force = damp(w.V_d - arm.V_WE) + apply(K, n, stacked(e_t + e_n, smallest_rotation(arm.X_WE.R.col(2), -n)));
  w.push = stacked(-out_.push * n, Eigen::Vector3d::Zero());
  return w;
}

Vector6 ImpedanceController::damp(const Vector6& V) const noexcept {
  if (settings_.inertia == InertiaShaping::natural) return modal_damping_.apply(space_.inertia_factor(), V);
  return apply(shaped_damping_, out_.n_WD, V);
}

// What Coulomb friction at the tip explains of the wrench: along −v_t, up to μ̂ f_n.
Vector6 ImpedanceController::tip_friction(const ArmTerms& arm, const Wrench& F_ext) const noexcept {
  Vector6 friction = Vector6::Zero();
  if (out_.mode != ContactMode::contact || settings_.friction <= 0.0) return friction;
  const Eigen::Vector3d& n = out_.n_WD;
  const double f_n = std::max(0.0, n.dot(F_ext.head<3>()));
  const Eigen::Vector3d v = arm.V_WE.head<3>();
  const Eigen::Vector3d v_t = v - n * n.dot(v);
  const Eigen::Vector3d slip = v_t / std::sqrt(v_t.squaredNorm() + settings_.friction_speed * settings_.friction_speed);
  const double against_slip = -F_ext.head<3>().dot(slip);
  friction.head<3>() = -std::clamp(against_slip, 0.0, settings_.friction * f_n) * slip;
  return friction;
}

void ImpedanceController::limit_torque() noexcept {
  for (int i = 0; i < out_.tau.size(); ++i) {
    const double clipped = std::clamp(out_.tau[i], -torque_limit_[i], torque_limit_[i]);
    out_.status.torque_limited |= clipped != out_.tau[i];
    out_.tau[i] = clipped;
  }
}

}  // namespace impedraw

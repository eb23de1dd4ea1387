#include "impedraw/control/impedance.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "impedraw/common/errors.h"
#include "impedraw/control/check_settings.h"
#include "impedraw/control/contact_stability.h"

namespace impedraw {

namespace {

// K' of docs/theory.md, Damping: where a stiffness is zero, the reference sizes the damping.
TipGain with_reference(const TipGain& k, const TipGain& reference) {
  const auto pick = [](double value, double fallback) { return value > 0.0 ? value : fallback; };
  return {{pick(k.linear.tangent, reference.linear.tangent),
           pick(k.linear.normal, reference.linear.normal)},
          {pick(k.angular.tangent, reference.angular.tangent),
           pick(k.angular.normal, reference.angular.normal)}};
}

}  // namespace

ImpedanceController::ImpedanceController(const ImpedanceSettings& settings, int joints)
    : settings_((check_settings(settings, joints), settings)),
      shaped_(settings.inertia == InertiaShaping::shaped),
      measured_(settings.wrench == WrenchFeedback::measured),
      scale_(settings.inertia == InertiaShaping::scaled ? settings.inertia_scale : 1.0),
      q_0_(settings.q_0),
      null_stiffness_(settings.null_stiffness),
      lower_(settings.joint_lower),
      upper_(settings.joint_upper),
      space_(settings.operational_space),
      observer_(settings.observer, joints, settings.dt,
                std::max(0.0, settings.wrench_delay - settings.dt), settings.torque_delay),
      limits_(settings.torque_limit, settings.torque_rate_limit, settings.dt),
      tracker_(settings.normal_bandwidth, settings.dt),
      contact_(settings.contact, settings.dt) {
  // Across the normal the reference is what holds in contact; the stiffness of free motion must not
  // change the damping at a switch.
  settings_.reference_stiffness = with_reference(settings.stiffness, settings.reference_stiffness);
  if (!measured_ && (shaped_ || scale_ != 1.0))
    throw InputError(std::string("inertia '") + (shaped_ ? "shaped" : "scaled") +
                     "' needs a measured wrench; without one the desired inertia must be 'natural' "
                     "or the force is not the push");
  if (shaped_) {
    shaped_damping_ = diagonal_damping(settings_.reference_stiffness, settings.shaped_inertia,
                                       settings.damping_ratio);
    check_damping_rates(shaped_damping_, settings.shaped_inertia,
                        settings.dt + settings.loop_delay);
    check_contact_stability(settings.shaped_inertia.linear.normal, shaped_damping_.linear.normal,
                            settings);
  } else if (scale_ < 1.0) {
    check_scaled_contact_stability(scale_, settings_.reference_stiffness.linear.normal, settings);
  }
  out_.tau = JointVector::Zero(joints);
  out_.terms.setZero(joints, kTorqueTerms);
}

void ImpedanceController::reset() noexcept {
  forget();
  limits_.reset();
  hand_over_ = false;
}

// What may no longer be so once control was lost for a while. The torque still starts from where it
// is.
void ImpedanceController::forget() noexcept {
  contact_.reset();
  observer_.reset();
  last_mode_ = ContactMode::free;
  on_surface_ = false;
  force_integral_ = 0.0;
  carried_force_.setZero();
  last_force_.setZero();
  hand_over_ = true;
}

// The input has the sizes and the numbers that a step can work with.
bool ImpedanceController::valid(const ArmTerms& arm, const TipReference& reference,
                                const SurfaceEstimate& surface,
                                const Wrench& F_ext) const noexcept {
  const auto n = out_.tau.size();
  if (arm.q.size() != n || arm.v.size() != n || arm.M.rows() != n || arm.M.cols() != n ||
      arm.Cv.size() != n || arm.g.size() != n || arm.J.cols() != n ||
      !(std::abs(reference.n_WD.squaredNorm() - 1.0) < 1e-6))
    return false;
  double sum = arm.q.sum() + arm.v.sum() + arm.M.sum() + arm.Cv.sum() + arm.g.sum() + arm.J.sum() +
               arm.Jdot_v.sum() + arm.X_WE.p.sum() + arm.X_WE.R.sum() + arm.V_WE.sum() +
               reference.p_WD.sum() + reference.v_WD.sum() + reference.a_WD.sum() +
               reference.n_WD.sum() + reference.w_WD.sum() + reference.alpha_WD.sum();
  if (surface.status == SurfaceStatus::ok) {
    if (!(std::abs(surface.n_W.squaredNorm() - 1.0) < 1e-6)) return false;
    sum += surface.n_W.sum() + surface.distance;
  }
  if (measured_) sum += F_ext.sum();
  return std::isfinite(sum);
}

// The pen rests on what holds the arm still; a velocity that may be anything is no use for braking.
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

const ImpedanceTorque& ImpedanceController::step(const ArmTerms& arm, const TipReference& reference,
                                                 const SurfaceEstimate& surface,
                                                 const Wrench& F_given,
                                                 const InputAges& ages) noexcept {
  const bool was_limited = out_.status.torque_limited;
  out_.status = {};
  out_.status.stale_state = !(ages.state <= settings_.max_state_age);
  out_.status.stale_wrench = measured_ && !(ages.wrench <= settings_.max_wrench_age);
  const Wrench F_ext = measured_ && !out_.status.stale_wrench ? F_given : Wrench(Wrench::Zero());
  out_.status.bad_input = !valid(arm, reference, surface, F_ext);
  if (out_.status.bad_input || out_.status.stale_state) return safe_torque();

  out_.status.near_singular = !space_.update(arm);
  update_mode(reference, surface, F_ext);
  if (!was_limited) update_force_integral(F_ext);

  const Eigen::Vector3d& n = out_.n_WD;
  if (!shaped_) {
    const TipGain& K = settings_.reference_stiffness;
    modal_damping_.design(space_.inverse_inertia_factor(), K.linear.matrix(n), K.angular.matrix(n),
                          settings_.damping_ratio);
    const double rate = modal_damping_.largest_rate() / std::sqrt(scale_);
    out_.status.damping_limit = rate * (settings_.dt + settings_.loop_delay) >= kDampingLimit;
  }
  ReferenceMotion desired = on_surface_ ? reference_on_surface(arm, reference, surface)
                                        : reference_on_plan(arm, reference);

  // What a switch would change at once is carried over and fades.
  if (out_.mode != last_mode_ || hand_over_)
    carried_force_ = last_force_ - (desired.force + desired.push);
  hand_over_ = false;
  last_mode_ = out_.mode;
  last_force_ = desired.force + desired.push + carried_force_;
  desired.force += carried_force_;
  carried_force_ *= 1.0 - settings_.dt / settings_.switch_time;

  // F_act of (11), a column a term: Λ (V̇_d − J̇v), and Λ M_d⁻¹ of each force. Λ M_d⁻¹ is 1/c where
  // M_d = c Λ.
  Eigen::Matrix<double, 6, kVelocityProduct + 1> F;
  const Vector6 kept =
      measured_ ? Vector6(F_ext - tip_friction(arm, F_ext)) : Vector6(Vector6::Zero());
  F.col(kFeedforward) = desired.Vdot_d;
  F.col(kVelocityProduct) = -arm.Jdot_v;
  if (shaped_) {
    const TipGain mobility = settings_.shaped_inertia.inverse();
    F.col(kImpedance) = mobility.apply(n, desired.force);
    F.col(kPush) = mobility.apply(n, desired.push);
    F.col(kWrench) = mobility.apply(n, kept);
    F = (space_.inertia() * F).eval();
  } else {
    F.col(kFeedforward) = space_.inertia() * desired.Vdot_d;
    F.col(kVelocityProduct) = -(space_.inertia() * arm.Jdot_v);
    F.col(kImpedance) = desired.force / scale_;
    F.col(kPush) = desired.push / scale_;
    F.col(kWrench) = kept / scale_;
  }
  F.col(kWrench) -= F_ext;
  if (!measured_ && settings_.friction_feedforward > 0.0 && out_.mode == ContactMode::contact) {
    const Eigen::Vector3d v_d = desired.V_d.head<3>();
    const double speed =
        std::sqrt(v_d.squaredNorm() + settings_.friction_speed * settings_.friction_speed);
    F.col(kFeedforward).head<3>() += settings_.friction_feedforward * out_.push / speed * v_d;
  }
  F.col(kVelocityProduct) += space_.project_to_tip(arm.Cv);

  const JointVector D_q = 2.0 * settings_.null_damping_ratio *
                          null_stiffness_.cwiseProduct(arm.M.diagonal()).cwiseSqrt();
  const JointVector tau_null =
      null_stiffness_.cwiseProduct(q_0_ - arm.q) - D_q.cwiseProduct(arm.v) + limit_repulsion(arm.q);

  const bool observed = measured_ && settings_.observer.enabled;
  out_.terms.leftCols<kVelocityProduct + 1>() = arm.J.transpose().lazyProduct(F);
  out_.terms.col(kNullSpace) =
      tau_null - arm.J.transpose().lazyProduct(space_.project_to_tip(tau_null));
  out_.terms.col(kGravity) = arm.g;
  const bool observes = observed && !out_.status.stale_wrench;
  if (observes)
    observer_.update(arm, F_ext);
  else
    observer_.pause();
  if (observed) out_.terms.col(kDisturbance) = -observer_.disturbance();

  // Numbers can be finite and still no arm's: an M that is not positive definite.
  out_.status.bad_input = !std::isfinite(out_.terms.sum());
  if (out_.status.bad_input) {
    out_.terms.col(kGravity) = arm.g;
    return safe_torque();
  }
  const LimitedTorque limited = limits_.apply(out_.terms.rightCols<2>().rowwise().sum(),
                                              out_.terms.leftCols<kNullSpace>().rowwise().sum(),
                                              out_.terms.col(kNullSpace), arm, space_);
  out_.tau = limited.tau;
  out_.task_share = limited.task_share;
  out_.status.torque_limited = limited.limited;
  if (observes) observer_.commanded(out_.tau);
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

}  // namespace impedraw

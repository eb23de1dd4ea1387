#include "impedraw/control/impedance.h"

#include <algorithm>
#include <cmath>

#include "impedraw/control/heading.h"
#include "impedraw/control/plan_turn.h"

namespace impedraw {

namespace {

// ρ of torque_limits.h: 0.9 while no joint is above 0.3 of its speed limit, 0 from 0.6 on. What
// hits the pen turns the wrist: at 0.27 m/s it was thrown to four times its limit without that.
double normal_first(const JointVector& v, const ImpedanceSettings& s) {
  constexpr double kMost = 0.9, kFull = 0.3, kNone = 0.6;
  if (s.limits.joint_speed.size() == 0) return kMost;
  const double fastest = v.cwiseAbs().cwiseQuotient(s.limits.joint_speed).maxCoeff();
  return kMost * std::clamp((kNone - fastest) / (kNone - kFull), 0.0, 1.0);
}

}  // namespace

ImpedanceController::ImpedanceController(const ImpedanceSettings& settings, int joints)
    : settings_((settings.validate(joints), settings.completed(joints))),
      measured_(settings.wrench == WrenchFeedback::measured),
      space_(settings.operational_space),
      range_(settings_),
      contact_(settings_),
      impedance_(settings_),
      stiff_contact_(settings_),
      hurried_torque_(settings_),
      push_(settings_),
      friction_(settings_),
      speed_limit_(settings_),
      handover_(settings.switch_time, settings.timing.dt),
      null_space_(settings_),
      joint_damper_(settings_),
      disturbance_(settings_, joints),
      limits_(settings_.limits.torque, settings_.limits.torque_rate, settings.timing.dt),
      brake_(settings_, joints) {
  out_.tau = JointVector::Zero(joints);
  out_.terms.setZero(joints, kTorqueTerms);
}

void ImpedanceController::retune(const TipGain& stiffness, double normal_force) {
  ImpedanceSettings changed = settings_;
  changed.stiffness = stiffness;
  changed.normal_force = normal_force;
  changed.validate(static_cast<int>(out_.tau.size()));
  settings_.stiffness = stiffness;
  settings_.normal_force = normal_force;
  impedance_.retune(stiffness);
  contact_.retune(normal_force);
}

const ImpedanceTorque& ImpedanceController::step(const ArmTerms& arm, const TipReference& reference,
                                                 const SurfaceEstimate& surface,
                                                 const Wrench& F_given, const InputAges& ages,
                                                 const FrameMotion* carrier) noexcept {
  const bool was_limited = out_.status.torque_limited;
  brake_.release();
  out_.status = input_status(arm, reference, surface, F_given, ages, settings_, out_.tau.size());
  if (out_.status.bad_input || out_.status.stale_state) return hold_with_gravity();
  const bool lost = out_.status.stale_wrench;
  const Wrench F_ext = measured_ && !lost ? F_given : Wrench(Wrench::Zero());

  // The pen's place: Λ and J̄ (8), (16), mode and normal of the contact, M_d and B
  out_.status.near_singular = !space_.update(arm);
  const TipReference followed = with_followed_turn(arm, space_, settings_.limits, reference);
  const StepInput in{arm, followed, surface, F_ext, lost, carrier};
  const Contact& contact = contact_.update(in);
  impedance_.update(space_, contact.n,
                    std::max(stiff_contact_.update(contact, F_ext),
                             hurried_torque_.update(contact, F_ext, was_limited)));

  // The wishes: F_push, V_d, V̇_d and K e (13)
  const Vector6 F_push = push_.update(contact, F_ext, handover_.carried().head<3>(), was_limited,
                                      fastest_push(arm, space_, impedance_, settings_, contact.n));
  TipTarget d = contact.on_surface() ? target_on_surface(in, contact, push_.built_up(), settings_)
                                     : target_on_plan(in, contact, settings_);
  const Eigen::Vector3d f_friction = friction_.feedforward(contact, d.V.head<3>());
  if (reference.led())
    lead_heading(reference, arm.X_WE, impedance_.stiffness().angular.normal, &d);
  else
    d.V.tail<3>() += heading_rate(arm, space_, range_) * arm.X_WE.R.col(2);
  out_.status.speed_limited = speed_limit_.apply(arm, space_, impedance_, range_, &d);

  // M_d (V̇ − V̇_d) = F_motion + F_push + F_compliant,  F_motion = B (V_d − V) + K e          (1)
  const Vector6 F_motion =
      handover_.smooth(contact.mode, impedance_.damp(d.V - arm.V_WE) + d.Ke, F_push);
  const Wrench F_compliant = F_ext - friction_.explained(contact, F_ext);

  // F_act = Λ (V̇_d − J̇v) + J̄ᵀ C v + Λ M_d⁻¹ (F_motion + F_push + F_compliant) − F_ext (10)–(11)
  Eigen::Matrix<double, 6, kVelocityProduct + 1> F_act;
  F_act.col(kFeedforward) = space_.inertia() * d.Vdot;
  F_act.col(kFeedforward).head<3>() += f_friction;
  F_act.col(kImpedance) = impedance_.to_arm(space_, F_motion);
  F_act.col(kPush) = impedance_.to_arm(space_, F_push);
  F_act.col(kWrench) = impedance_.to_arm(space_, F_compliant) - F_ext;
  F_act.col(kVelocityProduct) = space_.project_to_tip(arm.Cv) - space_.inertia() * arm.Jdot_v;

  // τ = Jᵀ F_act + (I − Jᵀ J̄ᵀ) τ_null + g − r_y                                   (12), (14)–(17)
  out_.terms.leftCols<kVelocityProduct + 1>() = arm.J.transpose().lazyProduct(F_act);
  out_.terms.col(kNullSpace) = null_space_.torque(arm, space_, range_);
  out_.terms.col(kGravity) = arm.g;
  out_.terms.col(kDisturbance) = disturbance_.compensation(in, space_);
  publish(contact, d, push_.desired());
  out_.status.damping_limit = impedance_.at_limit();
  out_.status.stiff_contact = stiff_contact_.own() > 0.0;
  out_.status.joint_limit = null_space_.near_range_end();

  // Finite inputs can still be invalid: M may not be positive definite.
  out_.status.bad_input = !std::isfinite(out_.terms.sum());
  if (out_.status.bad_input) return hold_with_gravity();
  const JointVector tau_damping = joint_damper_.torque(arm, space_, range_);
  out_.status.speed_limited |= joint_damper_.active();
  publish(limits_.apply(out_.terms.rightCols<2>().rowwise().sum(),
                        out_.terms.leftCols<kNullSpace>().rowwise().sum() + tau_damping,
                        out_.terms.col(kNullSpace), arm, space_, contact.n,
                        carrier ? normal_first(arm.v, settings_) : 0.0));
  disturbance_.commanded(in, out_.tau);
  return out_;
}

const ImpedanceTorque& ImpedanceController::brake(const ArmTerms& arm,
                                                  const Eigen::Vector3d& v_WD) noexcept {
  forget(true);
  out_.status = {};
  out_.status.bad_input = !arm.v.allFinite() || !arm.M.allFinite() || !arm.g.allFinite();
  if (out_.status.bad_input) return hold_with_gravity();
  out_.status.near_singular = !space_.update(arm);
  const Eigen::Vector3d n = -arm.X_WE.R.col(2);
  Contact none;
  none.n = n;
  TipTarget here;
  here.p_WD = arm.X_WE.p;
  here.axis_WD = n;
  publish(none, here, 0.0);
  out_.terms.setZero();
  out_.terms.col(kImpedance) = brake_.torque(arm, space_, v_WD);
  out_.terms.col(kGravity) = arm.g;
  out_.status.bad_input = !std::isfinite(out_.terms.sum()) || !space_.inertia().allFinite();
  if (out_.status.bad_input) return hold_with_gravity();
  return publish(limits_.nearest(out_.terms.rowwise().sum(), arm.M));
}

// Returns the last gravity torque, which holds the arm still. No damping: the velocity may be
// invalid.
const ImpedanceTorque& ImpedanceController::hold_with_gravity() noexcept {
  forget(true);
  out_.terms.leftCols<kGravity>().setZero();
  out_.terms.col(kDisturbance).setZero();
  out_.mode = ContactMode::free;
  out_.push = 0.0;
  LimitedTorque limited = limits_.clip(out_.terms.col(kGravity));
  limited.task_share = 0.0;
  return publish(limited);
}

// Fills all of the result but terms and status of the inputs.
void ImpedanceController::publish(const Contact& contact, const TipTarget& target,
                                  double push) noexcept {
  out_.mode = contact.mode;
  out_.push = push;
  out_.rise = contact.rise;
  out_.p_WD = target.p_WD;
  out_.n_WD = contact.n;
  out_.axis_WD = target.axis_WD;
  out_.status.surface_lost = contact.surface_lost;
}

const ImpedanceTorque& ImpedanceController::publish(const LimitedTorque& limited) noexcept {
  out_.tau = limited.tau;
  out_.task_share = limited.task_share;
  out_.status.torque_limited = limited.limited;
  return out_;
}

void ImpedanceController::reset() noexcept {
  forget(false);
  limits_.reset();
  stiff_contact_ = StiffContact(settings_);
}

// Clears state that may be invalid after a loss of control. The last torque is kept, for its rate.
void ImpedanceController::forget(bool from_zero) noexcept {
  contact_.reset();
  disturbance_.reset();
  push_.reset();
  hurried_torque_.reset();
  handover_.reset(from_zero);
}

}  // namespace impedraw

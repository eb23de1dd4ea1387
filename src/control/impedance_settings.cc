#include "impedraw/control/impedance_settings.h"

#include <string>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/control/contact_stability.h"
#include "impedraw/control/damping.h"

namespace impedraw {

namespace {

using Limits = ImpedanceSettings::Limits;

void check(const Limit& limit, double value) { require_in_range("control", limit, value); }

void check(const Limit& limit, const AxialGain& gain) {
  const std::string name = "control." + std::string(limit.name);
  require_in_range(name + "_tangent", gain.tangent, limit.range, limit.unit);
  require_in_range(name + "_normal", gain.normal, limit.range, limit.unit);
}

// One entry per joint, or none.
void check_entries(const std::string& name, const Eigen::VectorXd& x, int joints,
                   const Range& range, std::string_view unit) {
  if (x.size() != 0 && x.size() != joints)
    throw InputError(name + " has " + std::to_string(x.size()) + " entries, the arm " +
                     std::to_string(joints) + " joints");
  for (const double value : x) require_in_range(name, value, range, unit);
}

void check_timing(const TimingSettings& s) {
  check(Limits::dt, s.dt);
  check(Limits::loop_delay, s.loop_delay);
  check(Limits::wrench_delay, s.wrench_delay);
  check(Limits::velocity_age, s.velocity_age);
  check(Limits::velocity_lag, s.velocity_lag);
  check(Limits::max_state_age, s.max_state_age);
  check(Limits::max_wrench_age, s.max_wrench_age);
}

void check_dynamics(const ImpedanceSettings& s) {
  check(Limits::stiffness, s.stiffness.linear);
  check(Limits::rotational_stiffness, s.stiffness.angular);
  check(Limits::reference_stiffness, s.reference_stiffness.linear);
  check(Limits::reference_rotational_stiffness, s.reference_stiffness.angular);
  check(Limits::mass, s.shaped_inertia.linear);
  check(Limits::rotational_inertia, s.shaped_inertia.angular);
  check(Limits::inertia_scale, s.inertia_scale);
  check(Limits::damping_ratio, s.damping_ratio);
  check(Limits::normal_force, s.normal_force);
  check(Limits::switch_time, s.switch_time);
}

void check_surface(const SurfaceSettings& s) {
  require_in_range("control.drawing_axis_W length", s.drawing_axis_W.norm(), {1 - 1e-9, 1 + 1e-9},
                   "");
  check(Limits::min_axis_cosine, s.min_axis_cosine);
  check(Limits::normal_bandwidth, s.normal_bandwidth);
}

void check_approach(const ApproachSettings& s) {
  check(Limits::approach_speed, s.speed);
  check(Limits::approach_overtravel, s.overtravel);
  check(Limits::approach_lag, s.lag);
  check(Limits::retreat_height, s.retreat_height);
}

void check_felt_normal(const FeltNormalSettings& felt) {
  using Felt = FeltNormalSettings::Limits;
  check(Felt::share, felt.share);
  check(Felt::deviation, felt.deviation);
  check(Felt::force_error, felt.force_error);
}

void check_tip(const TipSettings& tip, const FrictionSettings& friction) {
  check(Limits::tip_radius, tip.radius);
  check(Limits::tip_stiffness, tip.stiffness);
  check(Limits::friction, friction.coefficient);
  check(Limits::normal_error, friction.normal_error_deg);
  check(Limits::friction_feedforward, friction.feedforward);
  check(Limits::fade_speed, friction.fade_speed);
}

void check_joints(const ImpedanceSettings& s, int joints) {
  const auto each = [joints](const Limit& limit, const Eigen::VectorXd& x) {
    check_entries("control." + std::string(limit.name), x, joints, limit.range, limit.unit);
  };
  each(Limits::null_stiffness, s.null_space.stiffness);
  check(Limits::null_damping_ratio, s.null_space.damping_ratio);
  check_entries("null_space.q_0", s.null_space.q_0, joints, Range::any(), "rad");
  check_entries("joint_range.lower", s.joint_range.lower, joints, Range::any(), "rad");
  check_entries("joint_range.upper", s.joint_range.upper, joints, Range::any(), "rad");
  if (s.joint_range.lower.size() != s.joint_range.upper.size())
    throw InputError("joint_range.lower and joint_range.upper: one is given without the other");
  check(Limits::limit_margin, s.joint_range.margin);
  check(Limits::limit_torque, s.joint_range.torque);
  const Limit& yield = ObserverSettings::Limits::yield_limit;
  check_entries(
      "control.observer.yield_limit",
      Eigen::Map<const Eigen::VectorXd>(s.observer.yield_limit.data(),
                                        static_cast<Eigen::Index>(s.observer.yield_limit.size())),
      joints, yield.range, yield.unit);
  check_entries("limits.torque", s.limits.torque, joints, Range::positive(), "Nm");
  each(Limits::torque_rate, s.limits.torque_rate);
  check_entries("limits.joint_speed", s.limits.joint_speed, joints, Range::positive(), "rad/s");
  check(Limits::tip_speed_limit, s.limits.tip_speed);
  check(Limits::turn_speed_limit, s.limits.turn_speed);
}

}  // namespace

TipGain ImpedanceSettings::damping_stiffness() const {
  const auto pick = [](double value, double fallback) { return value > 0.0 ? value : fallback; };
  const TipGain &k = stiffness, &reference = reference_stiffness;
  return {{pick(k.linear.tangent, reference.linear.tangent),
           pick(k.linear.normal, reference.linear.normal)},
          {pick(k.angular.tangent, reference.angular.tangent),
           pick(k.angular.normal, reference.angular.normal)}};
}

void ImpedanceSettings::validate_ranges(int joints) const {
  if (joints < 1 || joints > kMaxJoints)
    throw InputError("the number of joints is " + std::to_string(joints) + ", allowed is 1 to " +
                     std::to_string(kMaxJoints));
  check_timing(timing);
  check_dynamics(*this);
  check_surface(surface);
  check_approach(approach);
  contact.validate();
  check_tip(tip, friction);
  check_felt_normal(felt_normal);
  observer.validate();
  using Integral = ForceIntegralSettings::Limits;
  require_in_range("control.force_integral", Integral::rate, force_integral.rate);
  require_in_range("control.force_integral", Integral::limit, force_integral.limit);
  check(Limits::contact_stiffness_max, stability_check.contact_stiffness_max);
  check(Limits::natural_mass_max, stability_check.natural_mass_max);
  check_joints(*this, joints);
}

void ImpedanceSettings::validate_inertia() const {
  const bool shaped = inertia == InertiaShaping::shaped;
  const bool scaled = inertia == InertiaShaping::scaled && inertia_scale != 1.0;
  if (wrench == WrenchFeedback::none && (shaped || scaled))
    throw InputError(std::string("inertia '") + (shaped ? "shaped" : "scaled") +
                     "' needs a measured wrench; without one the desired inertia must be 'natural' "
                     "or the force is not the push");
  const TipGain K = damping_stiffness();
  if (shaped) {
    const TipGain B = diagonal_damping(K, shaped_inertia, damping_ratio);
    check_damping_rates(B, shaped_inertia, timing.damping_delay());
    check_contact_stability(shaped_inertia.linear.normal, B.linear.normal, *this);
  } else if (scaled && inertia_scale < 1.0) {
    check_scaled_contact_stability(inertia_scale, K.linear.normal, *this);
  }
}

void ImpedanceSettings::validate(int joints) const {
  validate_ranges(joints);
  validate_inertia();
}

ImpedanceSettings ImpedanceSettings::completed(int joints) const {
  ImpedanceSettings s = *this;
  const auto fill = [joints](Eigen::VectorXd& x, double value) {
    if (x.size() == 0) x = Eigen::VectorXd::Constant(joints, value);
  };
  fill(s.null_space.stiffness, 10.0);
  if (s.null_space.q_0.size() == 0 && s.joint_range.lower.size() != 0)
    s.null_space.q_0 = 0.5 * (s.joint_range.lower + s.joint_range.upper);
  fill(s.null_space.q_0, 0.0);
  fill(s.limits.torque, 1000.0);
  return s;
}

}  // namespace impedraw

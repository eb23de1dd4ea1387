#include "impedraw/control/impedance_settings.h"

#include <string>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/control/contact_stability.h"
#include "impedraw/control/damping.h"
#include "impedraw/control/describe_control.h"

namespace impedraw {

namespace {

// One entry per joint, or none.
void check_entries(const std::string& name, const Eigen::VectorXd& x, int joints,
                   const Range& range, std::string_view unit) {
  if (x.size() != 0 && x.size() != joints)
    throw InputError(name + " has " + std::to_string(x.size()) + " entries, the arm " +
                     std::to_string(joints) + " joints");
  for (const double value : x) require_in_range(name, value, range, unit);
}

// Settings that no scenario has, or none by this name.
void check_others(const ImpedanceSettings& s) {
  RangeChecks f("control");
  f.field("dt", s.timing.dt, Range::positive_to(0.1), "s");
  f.field("wrench_delay", s.timing.wrench_delay, {0.0, 1.0}, "s");
  f.field("velocity_age", s.timing.velocity_age, {0.0, 0.1}, "s");
  f.field("velocity_lag", s.timing.velocity_lag, {0.0, 1.1}, "s");
  f.field("mass_normal", s.shaped_inertia.linear.normal, kMassRange, "kg");
  f.field("drawing_axis_W length", s.surface.drawing_axis_W.norm(), {1 - 1e-9, 1 + 1e-9}, "");
  f.field("min_axis_cosine", s.surface.min_axis_cosine, Range::positive_to(1.0), "");
  f.field("normal_error", s.friction.normal_error_deg, kNormalErrorRange, "deg");
  f.field("fade_speed", s.friction.fade_speed, Range::positive(), "m/s");
  RangeChecks felt("control.felt_normal");
  describe_felt_normal(felt, s.felt_normal);
}

void check_joints(const ImpedanceSettings& s, int joints) {
  check_entries("control.null_stiffness", s.null_space.stiffness, joints, kNullStiffnessRange,
                "Nm/rad");
  check_entries("null_space.q_0", s.null_space.q_0, joints, Range::any(), "rad");
  check_entries("joint_range.lower", s.joint_range.lower, joints, Range::any(), "rad");
  check_entries("joint_range.upper", s.joint_range.upper, joints, Range::any(), "rad");
  if (s.joint_range.lower.size() != s.joint_range.upper.size())
    throw InputError("joint_range.lower and joint_range.upper: one is given without the other");
  check_entries(
      "control.observer.yield_limit",
      Eigen::Map<const Eigen::VectorXd>(s.observer.yield_limit.data(),
                                        static_cast<Eigen::Index>(s.observer.yield_limit.size())),
      joints, Range::any(), "Nm");
  check_entries("limits.torque", s.limits.torque, joints, Range::positive(), "Nm");
  check_entries("control.torque_rate", s.limits.torque_rate, joints, kTorqueRateRange, "Nm/s");
  check_entries("limits.joint_speed", s.limits.joint_speed, joints, Range::positive(), "rad/s");
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
  require_ranges("control", *this);
  contact.validate();
  observer.validate();
  check_others(*this);
  check_joints(*this, joints);
}

void ImpedanceSettings::validate_inertia() const {
  const bool shaped = inertia == InertiaShaping::shaped;
  const bool light = inertia == InertiaShaping::light_normal,
             scaled = (inertia == InertiaShaping::scaled || light) && inertia_scale != 1.0;
  if (wrench == WrenchFeedback::none && (shaped || scaled))
    throw InputError(std::string("inertia '") +
                     (shaped  ? "shaped"
                      : light ? "light_normal"
                              : "scaled") +
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

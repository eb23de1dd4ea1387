#include "impedraw/control/impedance_settings.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "impedraw/common/errors.h"
#include "impedraw/control/contact_stability.h"
#include "impedraw/control/damping.h"

namespace impedraw {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

void require(bool holds, const char* name, double value, const char* valid) {
  if (holds) return;
  char message[256];
  std::snprintf(message, sizeof message, "%s is %.6g; valid is %s", name, value, valid);
  throw InputError(message);
}
void positive(const char* name, double x) {
  require(x > 0.0 && x < kInfinite, name, x, "a number above 0");
}
void not_negative(const char* name, double x) {
  require(x >= 0.0 && x < kInfinite, name, x, "0 or a number above");
}

void gain(const std::string& name, const TipGain& g, void (*check)(const char*, double)) {
  check((name + " along the tangents").c_str(), g.linear.tangent);
  check((name + " along the normal").c_str(), g.linear.normal);
  check((name + " about the tangents").c_str(), g.angular.tangent);
  check((name + " about the normal").c_str(), g.angular.normal);
}

enum class Entries { any, not_negative, positive };

void each_joint(const char* name, const Eigen::VectorXd& x, int joints, Entries entries) {
  if (x.size() != 0 && x.size() != joints)
    throw InputError(std::string(name) + " has " + std::to_string(x.size()) + " entries, the arm " +
                     std::to_string(joints) + " joints");
  for (double value : x) {
    const bool holds = entries == Entries::any        ? std::isfinite(value)
                       : entries == Entries::positive ? value > 0.0
                                                      : value >= 0.0;
    require(holds, name, value,
            entries == Entries::any        ? "a number"
            : entries == Entries::positive ? "above 0"
                                           : "0 or more");
  }
}

void check_timing(const TimingSettings& s) {
  positive("timing.dt", s.dt);
  not_negative("timing.loop_delay", s.loop_delay);
  not_negative("timing.wrench_delay", s.wrench_delay);
  not_negative("timing.max_state_age", s.max_state_age);
  not_negative("timing.max_wrench_age", s.max_wrench_age);
}

void check_surface(const SurfaceSettings& s) {
  require(std::abs(s.drawing_axis_W.norm() - 1.0) < 1e-9, "surface.drawing_axis_W length",
          s.drawing_axis_W.norm(), "1");
  require(s.min_axis_cosine > 0.0 && s.min_axis_cosine <= 1.0, "surface.min_axis_cosine",
          s.min_axis_cosine, "above 0, at most 1");
  positive("surface.normal_bandwidth", s.normal_bandwidth);
}

void check_approach(const ApproachSettings& s) {
  positive("approach.speed", s.speed);
  not_negative("approach.overtravel", s.overtravel);
  positive("approach.lag", s.lag);
  not_negative("approach.retreat_height", s.retreat_height);
}

void check_tip(const TipSettings& tip, const FrictionSettings& friction) {
  not_negative("tip.radius", tip.radius);
  not_negative("tip.stiffness", tip.stiffness);
  not_negative("friction.coefficient", friction.coefficient);
  not_negative("friction.feedforward", friction.feedforward);
  positive("friction.fade_speed", friction.fade_speed);
}

void check_joints(const ImpedanceSettings& s, int joints) {
  each_joint("null_space.stiffness", s.null_space.stiffness, joints, Entries::not_negative);
  not_negative("null_space.damping_ratio", s.null_space.damping_ratio);
  each_joint("null_space.q_0", s.null_space.q_0, joints, Entries::any);
  each_joint("joint_range.lower", s.joint_range.lower, joints, Entries::any);
  each_joint("joint_range.upper", s.joint_range.upper, joints, Entries::any);
  if (s.joint_range.lower.size() != s.joint_range.upper.size())
    throw InputError("joint_range.lower and joint_range.upper: one is given without the other");
  positive("joint_range.margin", s.joint_range.margin);
  not_negative("joint_range.torque", s.joint_range.torque);
  each_joint("limits.torque", s.limits.torque, joints, Entries::positive);
  each_joint("limits.torque_rate", s.limits.torque_rate, joints, Entries::positive);
  positive("limits.tip_speed", s.limits.tip_speed);
  positive("limits.turn_speed", s.limits.turn_speed);
}

// Checks that the loop is stable with the desired inertia.
void check_inertia(const ImpedanceSettings& s) {
  const bool shaped = s.inertia == InertiaShaping::shaped;
  const bool scaled = s.inertia == InertiaShaping::scaled && s.inertia_scale != 1.0;
  if (s.wrench == WrenchFeedback::none && (shaped || scaled))
    throw InputError(std::string("inertia '") + (shaped ? "shaped" : "scaled") +
                     "' needs a measured wrench; without one the desired inertia must be 'natural' "
                     "or the force is not the push");
  const TipGain K = s.damping_stiffness();
  if (shaped) {
    const TipGain B = diagonal_damping(K, s.shaped_inertia, s.damping_ratio);
    check_damping_rates(B, s.shaped_inertia, s.timing.dt + s.timing.loop_delay);
    check_contact_stability(s.shaped_inertia.linear.normal, B.linear.normal, s);
  } else if (scaled && s.inertia_scale < 1.0) {
    check_scaled_contact_stability(s.inertia_scale, K.linear.normal, s);
  }
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

void ImpedanceSettings::validate(int joints) const {
  require(joints >= 1 && joints <= kMaxJoints, "the number of joints", joints, "1 to 12");
  check_timing(timing);
  gain("stiffness", stiffness, not_negative);
  gain("reference_stiffness", reference_stiffness, not_negative);
  gain("shaped_inertia", shaped_inertia, positive);
  positive("inertia_scale", inertia_scale);
  positive("damping_ratio", damping_ratio);
  not_negative("normal_force", normal_force);
  positive("switch_time", switch_time);
  check_surface(surface);
  check_approach(approach);
  contact.validate();
  check_tip(tip, friction);
  observer.validate();
  not_negative("force_integral.rate", force_integral.rate);
  not_negative("force_integral.limit", force_integral.limit);
  positive("stability_check.contact_stiffness_max", stability_check.contact_stiffness_max);
  positive("stability_check.natural_mass_max", stability_check.natural_mass_max);
  check_joints(*this, joints);
  check_inertia(*this);
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

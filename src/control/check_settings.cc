#include "impedraw/control/check_settings.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "impedraw/common/errors.h"

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

void each_joint(const char* name, const Eigen::VectorXd& x, int joints, bool may_be_empty,
                Entries entries) {
  if (x.size() != joints && !(may_be_empty && x.size() == 0))
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

}  // namespace

void check_settings(const ImpedanceSettings& s, int joints) {
  require(joints >= 1 && joints <= kMaxJoints, "the number of joints", joints, "1 to 12");
  positive("dt", s.dt);
  not_negative("loop_delay", s.loop_delay);
  not_negative("wrench_delay", s.wrench_delay);
  not_negative("torque_delay", s.torque_delay);
  gain("stiffness", s.stiffness, not_negative);
  gain("reference_stiffness", s.reference_stiffness, not_negative);
  gain("shaped_inertia", s.shaped_inertia, positive);
  positive("inertia_scale", s.inertia_scale);
  positive("damping_ratio", s.damping_ratio);
  not_negative("normal_force", s.normal_force);
  positive("switch_time", s.switch_time);
  positive("approach_speed", s.approach_speed);
  not_negative("approach_overtravel", s.approach_overtravel);
  positive("approach_lag", s.approach_lag);
  not_negative("retreat_height", s.retreat_height);
  positive("normal_bandwidth", s.normal_bandwidth);
  require(std::abs(s.drawing_axis_W.norm() - 1.0) < 1e-9, "drawing_axis_W length",
          s.drawing_axis_W.norm(), "1");
  require(s.min_axis_cosine > 0.0 && s.min_axis_cosine <= 1.0, "min_axis_cosine", s.min_axis_cosine,
          "above 0, at most 1");
  not_negative("tip_radius", s.tip_radius);
  not_negative("tip_stiffness", s.tip_stiffness);
  not_negative("friction", s.friction);
  not_negative("friction_feedforward", s.friction_feedforward);
  positive("friction_speed", s.friction_speed);
  not_negative("force_integral.rate", s.force_integral.rate);
  not_negative("force_integral.limit", s.force_integral.limit);
  positive("contact_stiffness_max", s.contact_stiffness_max);
  positive("natural_mass_max", s.natural_mass_max);
  not_negative("null_damping_ratio", s.null_damping_ratio);
  positive("limit_margin", s.limit_margin);
  not_negative("limit_torque", s.limit_torque);
  positive("tip_speed_limit", s.tip_speed_limit);
  not_negative("max_state_age", s.max_state_age);
  not_negative("max_wrench_age", s.max_wrench_age);
  each_joint("q_0", s.q_0, joints, false, Entries::any);
  each_joint("null_stiffness", s.null_stiffness, joints, false, Entries::not_negative);
  each_joint("torque_limit", s.torque_limit, joints, false, Entries::positive);
  each_joint("torque_rate_limit", s.torque_rate_limit, joints, true, Entries::positive);
  each_joint("joint_lower", s.joint_lower, joints, true, Entries::any);
  each_joint("joint_upper", s.joint_upper, joints, true, Entries::any);
  if (s.joint_lower.size() != s.joint_upper.size())
    throw InputError("joint_lower and joint_upper: one is given without the other");
}

}  // namespace impedraw

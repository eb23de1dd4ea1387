#include "impedraw/experiment/rest_posture.h"

#include <string>

#include <fmt/format.h>

#include "impedraw/arm/inverse_kinematics.h"

namespace impedraw {

namespace {

std::string joint_text(const JointVector& q) {
  std::string text;
  for (double x : q) text += fmt::format("{}{:.2f}", text.empty() ? "" : ", ", x);
  return text;
}

JointVector given_rest_posture(const std::vector<double>& given, const ArmModel& arm,
                               const SettingErrors& setting_errors) {
  // build_scene() has checked that there is one entry per joint.
  const JointVector q_0 = Eigen::Map<const Eigen::VectorXd>(given.data(), arm.joints());
  const JointVector lower = arm.limits().lower, upper = arm.limits().upper;
  if (((q_0 - lower).array() < 0.0).any() || ((upper - q_0).array() < 0.0).any())
    setting_errors.raise(
        {"arm.q_0"}, fmt::format("arm.q_0 ({}) rad lies beyond the joint ranges, ({}) to ({}) rad",
                                 joint_text(q_0), joint_text(lower), joint_text(upper)));
  return q_0;
}

}  // namespace

JointVector rest_posture(const ArmSettings& settings, const PlacedArtwork& artwork,
                         const std::vector<PlacedStroke>& strokes, const Belief& belief,
                         const SettingErrors& setting_errors) {
  if (!settings.q_0.empty()) return given_rest_posture(settings.q_0, belief.arm, setting_errors);
  const Eigen::Vector2d centre = artwork.placement.centre_m;
  auto middle = belief.surface(centre.x(), centre.y());
  for (std::size_t i = 0; i < strokes.size() && !middle; ++i) {
    const Eigen::Vector2d p = strokes[i].p_P[strokes[i].p_P.size() / 2];
    middle = belief.surface(p.x(), p.y());
  }
  const Eigen::Vector3d p_WE = middle ? artwork.X_WP * middle->p_P : settings.start_p_WE;
  ArmModel arm = belief.arm;
  return find_posture(arm, {p_WE, -artwork.X_WP.R.col(2)}, belief.start_q).q;
}

}  // namespace impedraw

#include "impedraw/drivers/foreign_arm.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace impedraw {

SessionSettings session_settings(const ArmSettings& settings, ArmModel arm,
                                 const JointVector& posture, std::span<const double> external) {
  constexpr double kExternalShare = 0.9, kSpeedShare = 1.2;
  SessionSettings s;
  s.torque_limit = arm.limits().torque;
  s.speed_limit = kSpeedShare * arm.limits().speed;
  s.rated_speed = arm.limits().speed;
  s.external_limit = kExternalShare *
                     JointVector(Eigen::Map<const Eigen::VectorXd>(external.data(), arm.joints()));
  ArmTerms terms(arm.joints());
  arm.compute(posture, JointVector::Zero(arm.joints()), &terms);
  s.damping = joint_damping(terms.M);
  s.inertia = terms.M;
  s.max_silence = settings.max_silence;
  return s;
}

void require_posture(const JointVector& q, const ArmLimits& limits,
                     const std::vector<std::string>& joint_names,
                     const std::optional<JointVector>& start_q) {
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const std::string& name = joint_names[static_cast<std::size_t>(j)];
    if (!(q[j] >= limits.lower[j] && q[j] <= limits.upper[j]))
      throw std::runtime_error(fmt::format(
          "{} stands at {:.3f} rad, beyond the {:.3f} to {:.3f} rad of arm.urdf: another arm, or "
          "another zero",
          name, q[j], limits.lower[j], limits.upper[j]));
    if (start_q && std::abs(q[j] - (*start_q)[j]) > ForeignArm::kStartTolerance)
      throw std::runtime_error(fmt::format(
          "{} stands at {:.3f} rad, the drawing starts at {:.3f} rad (within {:.2f} rad); "
          "./impedraw plan --json says where: start_q",
          name, q[j], (*start_q)[j], ForeignArm::kStartTolerance));
  }
}

}  // namespace impedraw

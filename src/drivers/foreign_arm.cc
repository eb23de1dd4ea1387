#include "impedraw/drivers/foreign_arm.h"

#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

namespace impedraw {

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

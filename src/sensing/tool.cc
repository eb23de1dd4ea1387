#include "impedraw/sensing/tool.h"

#include <cstdio>

#include <Eigen/Eigenvalues>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"

namespace impedraw {

Vector6 tool_wrench(const Tool& tool, const ToolMotion& motion,
                    const Eigen::Vector3d& gravity_W) noexcept {
  const Eigen::Matrix3d R_SW = motion.X_WS.R.transpose();
  const Eigen::Vector3d w = R_SW * motion.V_WS.tail<3>(), a = R_SW * motion.A_WS.head<3>(),
                        alpha = R_SW * motion.A_WS.tail<3>();
  const Eigen::Vector3d& c = tool.p_SC;

  Eigen::Vector3d at_centre = Eigen::Vector3d::Zero(), couple = Eigen::Vector3d::Zero();
  at_centre += tool.mass * (R_SW * gravity_W);
  at_centre -= tool.mass * (a + alpha.cross(c));
  couple -= tool.I_SC * alpha;
  at_centre -= tool.mass * w.cross(w.cross(c));  // centrifugal and gyroscopic
  couple -= w.cross(tool.I_SC * w);
  Vector6 wrench;
  wrench << at_centre, c.cross(at_centre) + couple;
  return wrench;
}

void check_tool(const Tool& tool) {
  require_in_range("tool", Tool::Limits::mass, tool.mass);
  require_in_range("tool", Tool::Limits::centre, tool.p_SC);
  if (!tool.I_SC.allFinite()) throw InputError("tool: I_SC, its inertia, must be finite");
  const double scale = tool.I_SC.cwiseAbs().maxCoeff(), slack = 1e-6 * scale;
  if ((tool.I_SC - tool.I_SC.transpose()).cwiseAbs().maxCoeff() > slack)
    throw InputError("tool: I_SC, its inertia, must be symmetric");
  const Eigen::Vector3d moments =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tool.I_SC, Eigen::EigenvaluesOnly)
          .eigenvalues();
  if (moments[0] < -slack || moments[2] > moments[0] + moments[1] + slack) {  // ascending
    char message[256];
    std::snprintf(message, sizeof message,
                  "tool: I_SC has the principal moments %.3g, %.3g, %.3g kg m²; none may be below "
                  "0, nor one above the sum of the others",
                  moments[0], moments[1], moments[2]);
    throw InputError(message);
  }
}

}  // namespace impedraw

// Wrench that the tool causes in a force-torque sensor between flange and pen.
//
// Law       f = m g       − m (a + α × c)               − m ω × (ω × c)
//           τ = c × m g   − c × m (a + α × c) − I α     − c × m ω × (ω × c) − ω × (I ω)
//               weight      inertia                       coriolis
// all in the axes of S, τ about the origin of S, c = p_SC; a, ω, α: acceleration of S's origin,
// angular velocity and angular acceleration. The three terms sum to the weight minus the rate of
// the tool's momentum. A wrench of the environment on the tool reads positive. The tool is
// everything on the far side of the sensor, including half of the sensor itself:
// tool_identification.h identifies it.
// Requires  R_WS a rotation, and a tool that passes check_tool(). tool_wrench() checks nothing.
// Source    Newton-Euler equations of one rigid body, moments about S's origin instead of C.
#pragma once

#include <cstdio>

#include <Eigen/Eigenvalues>

#include "impedraw/common/errors.h"
#include "impedraw/common/pose.h"
#include "impedraw/common/range.h"
#include "impedraw/common/range_check.h"

namespace impedraw {

struct Tool {
  double mass = 0.0;                               // m [kg]
  Eigen::Vector3d p_SC = Eigen::Vector3d::Zero();  // centre of mass, in S [m]
  // about the centre of mass, in the axes of S [kg m²]
  Eigen::Matrix3d I_SC = Eigen::Matrix3d::Zero();

  struct Limits {
    static constexpr Limit mass = {"mass", "kg", {0.0, 20.0}};
    static constexpr Limit centre = {"centre", "m", {-1.0, 1.0}};
  };
};

struct ToolMotion {
  Pose X_WS;                       // sensor frame
  Vector6 V_WS = Vector6::Zero();  // [velocity of S's origin; angular velocity], in W [m/s, rad/s]
  // [acceleration of S's origin; angular acceleration], in W [m/s², rad/s²]
  Vector6 A_WS = Vector6::Zero();
};

// [f; τ] of the law, in S [N, Nm].
inline Vector6 tool_wrench(const Tool& tool, const ToolMotion& motion,
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

// Checks at set-up that mass, centre and inertia are finite and physically possible; point masses
// are allowed. Throws InputError naming the fault, its value and what is valid.
inline void check_tool(const Tool& tool) {
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

// What a force-torque sensor between flange and pen reads because of the tool that hangs on it.
//
// Law       f = m g       − m (a + α × c)               − m ω × (ω × c)
//           τ = c × m g   − c × m (a + α × c) − I α     − c × m ω × (ω × c) − ω × (I ω)
//               weight      inertia                       coriolis
// all in the axes of S, τ about the origin of S, c = p_SC; a, ω, α: acceleration of S's origin,
// angular velocity and acceleration. With all three it is weight − rate of the tool's momentum: the
// sensor's sign is that of a wrench of the environment on the tool. The tool is everything on the
// sensor's far side, half of the sensor itself included: tool_identification.h finds it.
// Needs     R_WS a rotation, and a tool that check_tool() passes; tool_wrench() itself checks
//           nothing.
// Source    Newton's and Euler's equations of one rigid body, moments taken about S's origin
//           instead of C.
#pragma once

#include "impedraw/common/pose.h"

namespace impedraw {

struct Tool {
  double mass = 0.0;                               // m [kg]
  Eigen::Vector3d p_SC = Eigen::Vector3d::Zero();  // centre of mass, in S [m]
  // about the centre of mass, in the axes of S [kg m²]
  Eigen::Matrix3d I_SC = Eigen::Matrix3d::Zero();
};

struct ToolMotion {
  Pose X_WS;                       // sensor frame
  Vector6 V_WS = Vector6::Zero();  // [velocity of S's origin; angular velocity], in W [m/s, rad/s]
  // [acceleration of S's origin; angular acceleration], in W [m/s², rad/s²]
  Vector6 A_WS = Vector6::Zero();
};

// Which terms count.
struct ToolRemoval {
  bool weight = true;
  bool inertia = true;
  bool coriolis = true;
};

// [f; τ] of the law, in S [N, Nm].
Vector6 tool_wrench(const Tool& tool, const ToolMotion& motion, const Eigen::Vector3d& gravity_W,
                    const ToolRemoval& removal = {}) noexcept;

// At set-up. Throws InputError naming what is wrong, its value and what would be valid, unless
// mass, centre and inertia are finite and those of some rigid body, point masses included.
void check_tool(const Tool& tool);

}  // namespace impedraw

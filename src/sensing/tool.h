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

#include "impedraw/common/pose.h"
#include "impedraw/common/range.h"

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
Vector6 tool_wrench(const Tool& tool, const ToolMotion& motion,
                    const Eigen::Vector3d& gravity_W) noexcept;

// Checks at set-up that mass, centre and inertia are finite and physically possible; point masses
// are allowed. Throws InputError naming the fault, its value and what is valid.
void check_tool(const Tool& tool);

}  // namespace impedraw

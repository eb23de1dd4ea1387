// Identifies the mass and centre of mass of the tool on a force-torque sensor, and the sensor's
// bias, from readings at rest in several orientations.
//
// Law       f_k = m g_k + b_f          g_k = R_WSᵀ g_W of pose k          (tool.h at rest)
//           m_k = h × g_k + b_m        h = m p_SC
// Both are linear: least squares for (m, b_f), then for (h, b_m). The inertia is not observable at
// rest: take it from the CAD model. Orientations must rotate gravity in the sensor frame. Opposite
// pairs along three axes are best (condition 1.2); tilts of ± 30° about two axes give 5. At
// condition k, the worst determined combination of tool and bias is k times less certain than the
// best.
// Source    Atkeson, An, Hollerbach, "Estimation of inertial parameters of manipulator loads and
//           links", IJRR 5(3), 1986; static case.
#pragma once

#include <vector>

#include "impedraw/common/pose.h"

namespace impedraw {

struct StaticReading {  // S: the sensor's frame
  Eigen::Matrix3d R_WS = Eigen::Matrix3d::Identity();
  // [f; m], mean over a time at rest with nothing touching the tool [N, Nm]
  Vector6 reading_S = Vector6::Zero();
};

struct ToolIdentification {
  double mass = 0.0;                               // [kg]
  Eigen::Vector3d p_SC = Eigen::Vector3d::Zero();  // [m]
  Vector6 bias_S = Vector6::Zero();                // [N, Nm]
  // RMS per axis, √(Σ r²/(3N − 4)): the readings' noise if the law holds [N]
  double residual_force = 0.0;
  double residual_torque = 0.0;                          // √(Σ r²/(3N − 6)) [Nm]
  double mass_error = 0.0;                               // standard error, from the residuals [kg]
  Eigen::Vector3d p_SC_error = Eigen::Vector3d::Zero();  // [m]
  double condition = 0.0;  // larger of both problems' condition numbers, gravity as unit; ideal: 1
};

inline constexpr double kMaxCondition = 30.0;

// Throws InputError for fewer than 3 poses, an invalid rotation or reading, zero gravity,
// orientations that do not determine the tool (the message names what is undetermined), or an
// estimated mass of 0 or less (readings of the opposite sign).
ToolIdentification identify_tool(const std::vector<StaticReading>& poses,
                                 const Eigen::Vector3d& gravity_W = {0.0, 0.0, -9.81});

}  // namespace impedraw

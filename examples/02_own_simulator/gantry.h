// A fictitious arm with closed-form terms. Three rails along x, y, z of W carry a wrist of three
// joints whose axes meet in one point. The wrist holds the pen, which points down at q = 0.
//
// Joints      q = [x, y, z; a, b, c]: position of the wrist [m], rotations about x, then y, then
//             the pen [rad]. Rows of M v̇, Cv, g: forces for rails, torques for rotations.
// Tip         R_WE = Rx(a) Ry(b) Rz(c) diag(1, −1, −1),  p_WE = p + ℓ z_E;  ω = A [ȧ, ḃ, ċ], the
//             columns of A the three axes in W
// Dynamics    sums over rails and bodies, as for any arm:  M = Σ (m Jᵀ J + Aᵀ I A),  C v = Σ (m Jᵀ
//             J̇v + Aᵀ I Ȧv),  g = −Σ m Jᵀ gravity,
//             where J is that of a body's centre of mass and I that of a ball, so ω × I ω = 0
// J has full rank except at b = ± 90°, where the axes of a and c coincide.
#pragma once

#include <cmath>

#include "impedraw/control/arm_terms.h"

struct Gantry {
  Eigen::Vector3d rail_mass{6.0, 5.0, 3.0};  // mass moved by each rail, without the pen [kg]
  // inertia of a ball centred at the wrist's centre [kg m²]
  double wrist_inertia = 0.02;
  double pen_mass = 0.2;                       // [kg], a point on the pen's axis ...
  double pen_centre = 0.05;                    // ... at this distance from the wrist's centre [m]
  double tip = 0.12;                           // ℓ [m]
  Eigen::Vector3d gravity_W{0.0, 0.0, -9.81};  // [m/s²]

  void compute(const impedraw::JointVector& q, const impedraw::JointVector& v,
               impedraw::ArmTerms* arm) const {
    using Eigen::Matrix3d, Eigen::Vector3d;
    const double sa = std::sin(q[3]), ca = std::cos(q[3]), sb = std::sin(q[4]), cb = std::cos(q[4]);
    const double sc = std::sin(q[5]), cc = std::cos(q[5]);
    Matrix3d axes, R_c;     // A: one axis per column, in W
    axes << 1.0, 0.0, sb,   //
        0.0, ca, -sa * cb,  //
        0.0, sa, ca * cb;
    R_c << cc, sc, 0.0,  // Rz(c) diag(1, −1, −1)
        sc, -cc, 0.0,    //
        0.0, 0.0, -1.0;
    const Vector3d z_E = -axes.col(2), w = axes * v.tail<3>();
    Matrix3d R_ab;  // its z axis is the pen's axis, upwards
    R_ab << axes.col(1).cross(axes.col(2)), axes.col(1), axes.col(2);
    // Each axis rotates with the preceding joints.
    const Vector3d w_a = axes.col(0) * v[3], w_ab = w_a + axes.col(1) * v[4];
    const Vector3d spin_drift = w_a.cross(axes.col(1)) * v[4] + w_ab.cross(axes.col(2)) * v[5];

    // For the point at `distance` along the pen: J, and the drift J̇ v.
    const auto jacobian = [&](double distance) {
      Eigen::Matrix<double, 3, 6> J;
      J << Matrix3d::Identity(), Matrix3d::Zero();
      for (int j = 0; j < 3; ++j) J.col(3 + j) = axes.col(j).cross(distance * z_E);
      return J;
    };
    const auto point_drift = [&](double distance) -> Vector3d {
      return distance * (spin_drift.cross(z_E) + w.cross(w.cross(z_E)));
    };

    arm->q = q;
    arm->v = v;
    arm->M.setZero();
    arm->M.diagonal().head<3>() = rail_mass;
    arm->M.bottomRightCorner<3, 3>() = wrist_inertia * axes.transpose() * axes;
    arm->Cv << Vector3d::Zero(), wrist_inertia * axes.transpose() * spin_drift;
    arm->g << 0.0, 0.0, -rail_mass.z() * gravity_W.z(), Vector3d::Zero();
    const Eigen::Matrix<double, 3, 6> J_pen = jacobian(pen_centre);
    arm->M += pen_mass * J_pen.transpose() * J_pen;
    arm->Cv += pen_mass * J_pen.transpose() * point_drift(pen_centre);
    arm->g -= pen_mass * J_pen.transpose() * gravity_W;

    arm->J << jacobian(tip), Matrix3d::Zero(), axes;
    arm->Jdot_v << point_drift(tip), spin_drift;
    arm->X_WE = {q.head<3>() + tip * z_E, R_ab * R_c};
    arm->V_WE = arm->J * v;
  }
};

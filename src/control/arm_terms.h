// Joint- and task-space terms of the arm's rigid-body dynamics at one instant, as the control law
// needs them.
//
// Plant (2):  M v̇ + C v + g = τ + Jᵀ F_ext          Task (5)–(7):  V = J v,  V̇ = J v̇ + J̇ v
#pragma once

#include "impedraw/common/pose.h"

namespace impedraw {

// Fixed storage: the control loop allocates nothing. The size in use is set at construction.
inline constexpr int kMaxJoints = 12;

using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxJoints, 1>;
using JointMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxJoints, kMaxJoints>;
using TipJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxJoints>;

// n joints, n ≤ kMaxJoints; M symmetric positive definite. A prismatic joint uses m, m/s, N and kg.
// Spatial quantities are expressed in W and taken at the origin of E, linear part first
// (LOCAL_WORLD_ALIGNED).
struct ArmTerms {
  JointVector q, v;  // joint position [rad], velocity [rad/s]
  JointMatrix M;     // joint inertia, n×n, both triangles filled [kg m²]
  JointVector Cv;    // Coriolis and centrifugal torque (paper: V) [Nm]
  JointVector g;     // gravity torque: τ = g holds the arm still [Nm]
  TipJacobian J;     // 6×n, V_WE = J v
  Vector6 Jdot_v;    // drift acceleration J̇ v [m/s², rad/s²]
  Pose X_WE;         // pen tip
  Vector6 V_WE;      // its spatial velocity [m/s, rad/s]

  explicit ArmTerms(int n = 0)
      : q(JointVector::Zero(n)),
        v(JointVector::Zero(n)),
        M(JointMatrix::Zero(n, n)),
        Cv(JointVector::Zero(n)),
        g(JointVector::Zero(n)),
        J(TipJacobian::Zero(6, n)),
        Jdot_v(Vector6::Zero()),
        V_WE(Vector6::Zero()) {}
};

}  // namespace impedraw

// The wrench at the flange, from the balance of momentum of all that hangs below it. For this
// folder's sources alone.
//
// Over a step of h, bodies below link `flange` together: mass m, c.o.m. c, momentum P, angular
// momentum L about c, in W:
//   f   = f_env + m g − (P⁺ − P)/h            m_c = m_env − (L⁺ − L)/h            m_env about c
//   m_S = m_c + (c − S) × f                   then into the axes of S
// c, S and its axes are those at the start of the step, where its forces act too; P and L are exact
// at both of its ends. [f; m] is what those bodies do to the flange: at rest their weight.
#pragma once

#include <vector>

#include <mujoco/mujoco.h>

#include "impedraw/common/pose.h"

namespace impedraw {

struct CarriedMomentum {
  Pose X_WS;                                      // flange
  Eigen::Vector3d c_W = Eigen::Vector3d::Zero();  // [m]
  Eigen::Vector3d P_W = Eigen::Vector3d::Zero();  // [N s]
  Eigen::Vector3d L_W = Eigen::Vector3d::Zero();  // about c [N m s]
};

class FlangeBalance {
 public:
  explicit FlangeBalance(const mjModel* model);

  bool has_flange() const { return flange_ >= 0; }  // a link `flange` with `tip` below it

  // At the state whose positions and velocities `data` has. Needs has_flange().
  CarriedMomentum momentum(const mjModel* model, const mjData* data) const noexcept;

  // Mean over the step from `start` to `end`. F_env: force and moment about start.c_W, in W. With
  // end = start and no F_env: at rest.
  Vector6 wrench(const CarriedMomentum& start, const CarriedMomentum& end, const Vector6& F_env_W,
                 double dt) const noexcept;

 private:
  int flange_ = -1;
  std::vector<int> carried_;  // bodies with mass
  double mass_ = 0.0;
  Eigen::Vector3d weight_W_ = Eigen::Vector3d::Zero();
};

}  // namespace impedraw

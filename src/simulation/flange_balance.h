// Wrench at the flange from the momentum balance of the bodies below it. Only this folder's sources
// include this header.
//
// Over a step of h, for all bodies below link `flange` together: mass m, c.o.m. c, momentum P,
// angular momentum L about c, in W:
//   f   = f_env + m g − (P⁺ − P)/h            m_c = m_env − (L⁺ − L)/h            m_env about c
//   m_S = m_c + (c − S) × f                   then into the axes of S
// c, S and its axes are taken at the start of the step, where the forces act. P and L are exact at
// both ends. [f; m] is the wrench of those bodies on the flange: at rest, their weight.
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

  bool has_flange() const { return flange_ >= 0; }  // a link `flange` exists with `tip` below it

  // At the positions and velocities in `data`. Requires has_flange().
  CarriedMomentum momentum(const mjModel* model, const mjData* data) const noexcept;

  // Mean over the step from `start` to `end`. F_env: force and moment about start.c_W, in W. For
  // the wrench at rest, pass end = start and F_env = 0.
  Vector6 wrench(const CarriedMomentum& start, const CarriedMomentum& end, const Vector6& F_env_W,
                 double dt) const noexcept;

 private:
  int flange_ = -1;
  std::vector<int> carried_;  // bodies with mass
  double mass_ = 0.0;
  Eigen::Vector3d weight_W_ = Eigen::Vector3d::Zero();
};

}  // namespace impedraw

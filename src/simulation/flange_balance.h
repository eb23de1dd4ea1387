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
  explicit FlangeBalance(const mjModel* model) {
    const int flange = mj_name2id(model, mjOBJ_BODY, "flange"),
              tip = mj_name2id(model, mjOBJ_BODY, "tip");
    if (flange < 0 || tip < 0) return;
    const auto below = [&](int body) {
      while (body > 0 && body != flange) body = model->body_parentid[body];
      return body == flange;
    };
    if (tip == flange || !below(tip)) return;
    flange_ = flange;
    for (int body = 1; body < model->nbody; ++body) {
      if (body == flange || !below(body) || model->body_mass[body] <= 0.0) continue;
      carried_.push_back(body);
      mass_ += model->body_mass[body];
    }
    weight_W_ = mass_ * Eigen::Map<const Eigen::Vector3d>(model->opt.gravity);
  }

  bool has_flange() const { return flange_ >= 0; }  // a link `flange` exists with `tip` below it

  // At the positions and velocities in `data`. Requires has_flange().
  CarriedMomentum momentum(const mjModel* model, const mjData* data) const noexcept {
    CarriedMomentum sum;
    sum.X_WS.p = Eigen::Map<const Eigen::Vector3d>(data->xpos + 3 * flange_);
    sum.X_WS.R = Eigen::Map<const RowMatrix3>(data->xmat + 9 * flange_);
    if (carried_.empty()) {
      sum.c_W = sum.X_WS.p;
      return sum;
    }
    for (const int body : carried_)
      sum.c_W += model->body_mass[body] / mass_ *
                 Eigen::Map<const Eigen::Vector3d>(data->xipos + 3 * body);
    for (const int body : carried_) {
      double velocity[6];  // of the body's c.o.m., angular part first
      mj_objectVelocity(model, data, mjOBJ_BODY, body, velocity, 0);
      const Eigen::Map<const Eigen::Vector3d> w(velocity), v(velocity + 3),
          c(data->xipos + 3 * body), inertia(model->body_inertia + 3 * body);
      const Eigen::Map<const RowMatrix3> R(data->ximat + 9 * body);
      const Eigen::Vector3d P = model->body_mass[body] * v;
      sum.P_W += P;
      sum.L_W += R * inertia.cwiseProduct(R.transpose() * w) + (c - sum.c_W).cross(P);
    }
    return sum;
  }

  // Mean over the step from `start` to `end`. F_env: force and moment about start.c_W, in W. For
  // the wrench at rest, pass end = start and F_env = 0.
  Vector6 wrench(const CarriedMomentum& start, const CarriedMomentum& end, const Vector6& F_env_W,
                 double dt) const noexcept {
    const Eigen::Vector3d f = F_env_W.head<3>() + weight_W_ - (end.P_W - start.P_W) / dt;
    const Eigen::Vector3d m_c = F_env_W.tail<3>() - (end.L_W - start.L_W) / dt;
    const Eigen::Matrix3d R_SW = start.X_WS.R.transpose();
    Vector6 F_S;
    F_S << R_SW * f, R_SW * (m_c + (start.c_W - start.X_WS.p).cross(f));
    return F_S;
  }

 private:
  using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

  int flange_ = -1;
  std::vector<int> carried_;  // bodies with mass
  double mass_ = 0.0;
  Eigen::Vector3d weight_W_ = Eigen::Vector3d::Zero();
};

}  // namespace impedraw

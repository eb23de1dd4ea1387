// Dry friction of the joints' gears, the greatest torque that each can take [Nm]:
//
//   τ_f = (τ_c + λ |τ|) (1 + (s − 1) exp(−(v/v_s)²)) (1 + r sin(30 q + φ_j))
//
// τ_c: Coulomb friction; λ: load_friction; s: stiction, v_s: stribeck_speed (Stribeck's curve);
// r: friction_ripple, with the periods of the torque's ripple; τ: the load of the gear. Viscous
// friction stands beside it (ModelErrors).
#pragma once

#include <cmath>
#include <numbers>

#include "impedraw/control/arm_terms.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

class GearFriction {
 public:
  // coulomb: τ_c of each joint [Nm].
  GearFriction(const ModelErrors& errors, const JointVector& coulomb)
      : errors_(errors), coulomb_(coulomb) {}

  bool acts() const { return coulomb_.maxCoeff() > 0.0 || errors_.load_friction > 0.0; }

  JointVector most(const JointVector& v, const JointVector& q,
                   const JointVector& load) const noexcept {
    if (errors_.stiction == 1.0 && errors_.load_friction == 0.0 && errors_.friction_ripple == 0.0)
      return coulomb_;
    JointVector f = coulomb_ + errors_.load_friction * load.cwiseAbs();
    for (Eigen::Index j = 0; j < f.size(); ++j) {
      const double slow = v[j] / errors_.stribeck_speed;
      f[j] *=
          (1.0 + (errors_.stiction - 1.0) * std::exp(-slow * slow)) *
          (1.0 + errors_.friction_ripple * std::sin(ModelErrors::kRipplePeriods * q[j] + phase(j)));
    }
    return f;
  }

  // φ_j: unlike that of the torque's ripple (joint_drive.h).
  static double phase(Eigen::Index j) {
    return 2.0 * std::numbers::pi * 0.618034 * static_cast<double>(j + 1);
  }

 private:
  ModelErrors errors_;
  JointVector coulomb_;
};

}  // namespace impedraw

#include "impedraw/simulation/gear_friction.h"

#include <cmath>
#include <numbers>

namespace impedraw {

JointVector GearFriction::most(const JointVector& v, const JointVector& q,
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

double GearFriction::phase(Eigen::Index j) {
  return 2.0 * std::numbers::pi * 0.618034 * static_cast<double>(j + 1);
}

}  // namespace impedraw

// The end of a run that cannot continue: the pen lifts off along the surface normal and stays up.
#pragma once

#include <algorithm>

#include "impedraw/control/tip_reference.h"

namespace impedraw {

class EmergencyLift {
 public:
  static constexpr double kDuration = 1.0;  // [s]
  static constexpr double kHeight = 0.03;   // [m]

  EmergencyLift(double start, const Eigen::Vector3d& p_WE, const Eigen::Vector3d& n_W)
      : start_(start), p_(p_WE), n_(n_W) {}

  bool done(double t) const { return t >= start_ + kDuration; }
  // Minimum-jerk motion from rest to rest.
  TipReference at(double t) const {
    const double s = std::clamp((t - start_) / kDuration, 0.0, 1.0);
    TipReference reference;
    reference.n_WD = n_;
    reference.p_WD = p_ + kHeight * s * s * s * (10.0 + s * (6.0 * s - 15.0)) * n_;
    reference.v_WD = kHeight / kDuration * 30.0 * s * s * (1.0 - s) * (1.0 - s) * n_;
    reference.a_WD =
        kHeight / (kDuration * kDuration) * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) * n_;
    return reference;
  }

 private:
  double start_;
  Eigen::Vector3d p_, n_;
};

}  // namespace impedraw

// A lifted pen follows corrections of the canvas's estimate gently.
//
// The reference is carried by the canvas as it is estimated. Where a frame shows the forecast to be
// off, its position and velocity change by more than its velocity and acceleration explain:
//
//   Δp = p_k − (p + Δt v + Δt²/2 a)_{k−1}      Δv = v_k − (v + Δt a)_{k−1}
//
// A pen in the air need not dash after that, at half a metre a second towards a canvas that is not
// where it was thought to be. The reference keeps e and ė, from which it returns critically damped:
//
//   e ← e − Δp,  ė ← ė − Δv  in the air         ë = −2 kRate ė − kRate² e  always
//
// A motion that is as foreseen is followed without a lag.
#pragma once

#include "impedraw/control/tip_reference.h"

namespace impedraw {

class SoftCorrections {
 public:
  // Slower, the pen lags behind a canvas that rises; faster, it swings after forecasts [1/s].
  static constexpr double kRate = 30.0;

  // The carried reference, softened, once per step of dt [s]. in_air: the pen is up, by the plan
  // and by its contact state. Allocates nothing.
  TipReference of(TipReference reference, bool in_air, double dt) noexcept {
    if (known_ && in_air) {
      e_ -= reference.p_WD - last_.p_WD - dt * last_.v_WD - 0.5 * dt * dt * last_.a_WD;
      de_ -= reference.v_WD - last_.v_WD - dt * last_.a_WD;
    }
    last_ = reference;
    known_ = true;
    const Eigen::Vector3d a = -kRate * (2.0 * de_ + kRate * e_);
    de_ += dt * a;
    e_ += dt * de_;
    reference.p_WD += e_;
    reference.v_WD += de_;
    reference.a_WD += a;
    return reference;
  }
  void reset() noexcept { *this = {}; }

 private:
  TipReference last_;
  bool known_ = false;
  Eigen::Vector3d e_ = Eigen::Vector3d::Zero(), de_ = Eigen::Vector3d::Zero();  // [m], [m/s]
};

}  // namespace impedraw

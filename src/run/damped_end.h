// The end of a run whose arm is not believed: −D v beyond gravity, as far as positions confirm v,
// until the joints are calm, and for at most kDampTime. Zero beyond gravity follows. Sessions of
// driven arms end likewise (drivers/arm_session.h).
#pragma once

#include "impedraw/control/impedance.h"
#include "impedraw/run/motion_check.h"

namespace impedraw {

class DampedEnd {
 public:
  // v: confirmed [rad/s].
  bool over(const JointVector& v) const noexcept {
    return time_ >= kDampTime || v.cwiseAbs().maxCoeff() < kDampedSpeed;
  }

  // The torques of a cycle of dt [s] in place of the law's, with the gravity that `out` has from
  // the last cycle. M: inertia at the posture [kg m²]; v: confirmed [rad/s]; most: limits [Nm].
  void damp(const JointMatrix& M, const JointVector& v, const JointVector& most, double dt,
            ImpedanceTorque* out) noexcept {
    const JointVector gravity = out->terms.col(kGravity);
    time_ += dt;
    out->status = {};
    out->mode = ContactMode::free;
    out->push = 0.0;
    out->terms.setZero();
    out->terms.col(kGravity) = gravity;
    out->terms.col(kImpedance) = -joint_damping(M).cwiseProduct(v);
    out->tau = (out->terms.col(kImpedance) + gravity).cwiseMax(-most).cwiseMin(most);
  }

 private:
  double time_ = 0.0;  // [s]
};

}  // namespace impedraw

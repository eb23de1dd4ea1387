// A lifted pen yields to what hits it: its reference retreats along the force, and returns slowly.
//
//   m ẇ = f − b w           w: of the retreat; f: the measured force beyond kFelt
//   ṡ = w + kClearSpeed f̂   until kClear beyond the place where the force ended
//
// After kRest without a force, or once the pen comes down, s returns to zero at kReturn: never at
// once, or the pen would dash at what hit it. The law's own stiffness would otherwise push against
// a canvas that comes nearer, by its stiffness times the way.
#pragma once

#include <algorithm>

#include "impedraw/control/tip_reference.h"

namespace impedraw {

class HitRetreat {
 public:
  static constexpr double kFelt = 2.0;                   // [N]
  static constexpr double kMass = 0.3, kDamping = 20.0;  // m [kg], b [N s/m]
  static constexpr double kClear = 0.01;                 // [m]
  static constexpr double kRest = 1.0, kReturn = 0.02;   // [s], [m/s]
  static constexpr double kFurthest = 0.15;              // [m]

  // Once per step of dt [s]. lifted: the pen is in the air, by the plan and by its contact state;
  // force: on the tip, in W [N]. Allocates nothing.
  void update(const Eigen::Vector3d& force, bool lifted, double dt) noexcept {
    const double f = lifted ? force.norm() : 0.0;
    if (!lifted) {
      w_.setZero();
      left_ = 0.0;
      since_ = kRest;
    }
    Eigen::Vector3d beyond = Eigen::Vector3d::Zero();
    if (f > kFelt) {
      beyond = force * ((f - kFelt) / f);
      away_ = force / f;
      since_ = 0.0;
      left_ = kClear;
    }
    since_ += dt;
    w_ += dt / kMass * (beyond - kDamping * w_);
    if (left_ > 0.0) {
      const double way = std::min(left_, kClearSpeed * dt);
      left_ -= way;
      s_ += way * away_;
    }
    s_ += dt * w_;
    const double far = s_.norm();
    if (far > kFurthest) s_ *= kFurthest / far;
    if (since_ > kRest && far > 0.0) s_ *= std::max(0.0, 1.0 - kReturn * dt / far);
  }
  // The plan's reference, further away.
  TipReference of(TipReference reference) const noexcept {
    reference.p_WD += s_;
    reference.v_WD += w_;
    return reference;
  }
  const Eigen::Vector3d& shift() const noexcept { return s_; }

 private:
  static constexpr double kClearSpeed = 0.1;  // [m/s]

  Eigen::Vector3d s_ = Eigen::Vector3d::Zero(), w_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d away_ = Eigen::Vector3d::UnitZ();
  double since_ = 1e9, left_ = 0.0;
};

}  // namespace impedraw

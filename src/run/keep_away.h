// A pen that rests in the air, or whose motion is damped, keeps away from a canvas that comes
// nearer, as cameras see it.
//
// The reference moves along the surface's normal n, by s(t), so that the canvas is braked against:
//
//   ṡ ≥ v_C · n − √(2 a (d − kRoom))     where d > kRoom
//   ṡ ≥ v_C · n + kRate (kRoom − d)      nearer
//
// d: of the reference from the surface. ṡ changes by at most kMostAcceleration; a is half of that.
// Once the canvas is further away, s returns to zero at kReturn.
#pragma once

#include <algorithm>
#include <cmath>

#include "impedraw/control/surface_estimate.h"
#include "impedraw/control/tip_reference.h"

namespace impedraw {

class KeepAway {
 public:
  static constexpr double kRoom = 0.02, kFurthest = 0.25;  // [m]
  static constexpr double kMostAcceleration = 4.0;         // [m/s²]
  static constexpr double kRate = 5.0;                     // [1/s]
  static constexpr double kReturn = 0.05;                  // [m/s]

  // Once per step of dt [s]. surface: at the tip, in W; v_C: of the canvas there [m/s]. Allocates
  // nothing.
  void update(const SurfaceEstimate& surface, const Eigen::Vector3d& v_C, double dt) noexcept {
    const double far = s_.norm();
    double least = far > 0.0 ? -std::min(kReturn, 10.0 * far) : 0.0;
    if (surface.status == SurfaceStatus::ok) {
      if (far == 0.0) n_ = surface.n_W;
      const double room = surface.distance - kRoom, nearer = v_C.dot(n_);
      const double bound =
          room > 0.0 ? nearer - std::sqrt(kMostAcceleration * room) : nearer - kRate * room;
      least = std::max(least, bound);
    }
    const double most = kMostAcceleration * dt;
    const double change = std::clamp(least - rate_, -most, most);
    a_ = change / dt;
    rate_ += change;
    const double s = std::clamp(n_.dot(s_) + dt * rate_, 0.0, kFurthest);
    if (s == 0.0 || s == kFurthest) rate_ = a_ = 0.0;
    s_ = s * n_;
  }
  void reset() noexcept { *this = {}; }
  // The plan's reference, further away.
  TipReference of(TipReference reference) const noexcept {
    reference.p_WD += s_;
    reference.v_WD += rate_ * n_;
    reference.a_WD += a_ * n_;
    return reference;
  }
  const Eigen::Vector3d& shift() const noexcept { return s_; }
  // ṡ, where it leads away [m/s].
  Eigen::Vector3d retreat() const noexcept { return std::max(0.0, rate_) * n_; }

 private:
  Eigen::Vector3d s_ = Eigen::Vector3d::Zero(), n_ = Eigen::Vector3d::UnitZ();
  double rate_ = 0.0, a_ = 0.0;
};

}  // namespace impedraw

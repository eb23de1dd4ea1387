// A pen in the air keeps off a surface that is higher than the cameras saw it, as touch has shown.
//
// Cameras that all err alike, by the scale of their depths for instance, put the surface beneath
// where it is, and the plan with it. In contact the law goes by touch; the way up and the next way
// down are the plan's, and would press a spring into the surface. They are raised along the drawing
// axis z:
//
//   h = d / (n·z) − kBorne in contact, 0 ≤ h ≤ kMost    d: the estimated distance at touch
//   s → h, at kSpeed, near the surface; s → 0 farther up, where the pen rests at what it measures
//
// What a hover leaves room for, kBorne, raises nothing.
#pragma once

#include <algorithm>
#include <optional>

#include "impedraw/control/contact_mode.h"
#include "impedraw/control/surface_estimate.h"
#include "impedraw/control/tip_reference.h"

namespace impedraw {

class FeltHeight {
 public:
  static constexpr double kBorne = 4e-3, kMost = 0.02, kNear = 0.025;  // [m]
  static constexpr double kSpeed = 0.03;                               // [m/s]
  static constexpr double kFollows = 0.3;      // a hand that lifts the pen is quicker [s]
  static constexpr double kLeastCosine = 0.2;  // of n·z

  explicit FeltHeight(const Eigen::Vector3d& z_W) : z_W_(z_W) {}

  // Once per step of dt [s], with the surface at the tip. Allocates nothing.
  void update(const SurfaceEstimate& surface, ContactMode mode, double dt) noexcept {
    const bool known = surface.status == SurfaceStatus::ok;
    if (known && mode == ContactMode::contact) {
      const double above = surface.distance / std::max(kLeastCosine, surface.n_W.dot(z_W_));
      touched_ = touched_ ? *touched_ + dt / kFollows * (above - *touched_) : above;
      felt_ = std::clamp(*touched_ - kBorne, 0.0, kMost);
    }
    const double wanted = known && surface.distance < kNear ? felt_ : 0.0;
    s_ += std::clamp(wanted - s_, -kSpeed * dt, kSpeed * dt);
  }
  // The plan's reference, higher up.
  TipReference of(TipReference reference) const noexcept {
    reference.p_WD += s_ * z_W_;
    return reference;
  }

 private:
  Eigen::Vector3d z_W_;
  std::optional<double> touched_;  // above the surface as seen, lately [m]
  double felt_ = 0.0, s_ = 0.0;    // h and s [m]
};

}  // namespace impedraw

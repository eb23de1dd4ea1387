// Forces across the normal that contact at the tip explains: Coulomb friction, and the push of a
// surface whose normal is not the estimated one.
//
// Slip      s = v_t / √(v_t² + v_0²),  v_t: motion of the tip along the surface, v_0 = fade_speed
// Friction  −min(max(−f_t·s, 0), μ̂ f_n) s,  f_n = n·f > 0,  f_t = f − f_n n
// Normal    up to tan(normal_error) f_n across n, in the direction of what friction leaves of f_t,
//           |s| times: at rest it may be the spring's own pull, held by friction
// Feed-     without a measured wrench, μ̂_ff F_n along the desired motion on the carrier, faded out
// forward   below v_0
// In contact only.
#pragma once

#include "impedraw/control/contact.h"

namespace impedraw {

// s for a tip that moves at v along a surface of normal n [m/s].
Eigen::Vector3d slip_along(const Eigen::Vector3d& n, const Eigen::Vector3d& v,
                           double fade_speed) noexcept;

class TipFriction {
 public:
  explicit TipFriction(const ImpedanceSettings& settings) noexcept;

  // The part of a measured wrench that contact at the tip explains [N, Nm].
  Wrench explained(const Contact& contact, const Wrench& F_ext) const noexcept;
  // Force against the friction of the desired motion v_WD [m/s] under the push F_n of the contact.
  Eigen::Vector3d feedforward(const Contact& contact, const Eigen::Vector3d& v_WD) const noexcept;

 private:
  FrictionSettings settings_;
  bool measured_;
  double side_force_;  // tan(normal_error)
};

}  // namespace impedraw

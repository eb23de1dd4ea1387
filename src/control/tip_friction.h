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

#include <algorithm>
#include <cmath>
#include <numbers>

#include "impedraw/control/contact.h"

namespace impedraw {

// s for a tip that moves at v along a surface of normal n [m/s].
inline Eigen::Vector3d slip_along(const Eigen::Vector3d& n, const Eigen::Vector3d& v,
                                  double fade_speed) noexcept {
  const Eigen::Vector3d v_t = v - n * n.dot(v);
  return v_t / std::sqrt(v_t.squaredNorm() + fade_speed * fade_speed);
}

class TipFriction {
 public:
  explicit TipFriction(const ImpedanceSettings& s) noexcept
      : settings_(s.friction),
        measured_(s.wrench == WrenchFeedback::measured),
        side_force_(std::tan(s.friction.normal_error_deg * std::numbers::pi / 180.0)) {}

  // The part of a measured wrench that contact at the tip explains [N, Nm].
  Wrench explained(const Contact& contact, const Wrench& F_ext) const noexcept {
    Wrench explained = Wrench::Zero();
    if (!measured_ || contact.mode != ContactMode::contact) return explained;
    const Eigen::Vector3d& n = contact.n;
    const double f_n = std::max(0.0, n.dot(F_ext.head<3>()));
    const Eigen::Vector3d slip = slip_along(n, contact.v, settings_.fade_speed);
    const Eigen::Vector3d f_t = F_ext.head<3>() - n * n.dot(F_ext.head<3>());
    const Eigen::Vector3d friction = friction_in(f_t, slip, settings_.coefficient * f_n);
    const Eigen::Vector3d aside = slip.norm() * (f_t - friction);
    const double most = side_force_ * f_n;
    explained.head<3>() = friction + aside * (most / std::max(most, aside.norm() + 1e-9));
    return explained;
  }
  // Force against the friction of the desired motion v_WD [m/s] under the push F_n of the contact.
  Eigen::Vector3d feedforward(const Contact& contact, const Eigen::Vector3d& v_WD) const noexcept {
    if (measured_ || settings_.feedforward <= 0.0 || contact.mode != ContactMode::contact)
      return Eigen::Vector3d::Zero();
    const Eigen::Vector3d v_d = v_WD - contact.v_K;
    const double speed = std::sqrt(v_d.squaredNorm() + settings_.fade_speed * settings_.fade_speed);
    return settings_.feedforward * contact.force / speed * v_d;
  }

 private:
  FrictionSettings settings_;
  bool measured_;
  double side_force_;  // tan(normal_error)
};

}  // namespace impedraw

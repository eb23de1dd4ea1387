#include "impedraw/control/tip_friction.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace impedraw {

Eigen::Vector3d slip_along(const Eigen::Vector3d& n, const Eigen::Vector3d& v,
                           double fade_speed) noexcept {
  const Eigen::Vector3d v_t = v - n * n.dot(v);
  return v_t / std::sqrt(v_t.squaredNorm() + fade_speed * fade_speed);
}

TipFriction::TipFriction(const ImpedanceSettings& s) noexcept
    : settings_(s.friction),
      measured_(s.wrench == WrenchFeedback::measured),
      side_force_(std::tan(s.friction.normal_error_deg * std::numbers::pi / 180.0)) {}

Wrench TipFriction::explained(const Contact& contact, const Wrench& F_ext) const noexcept {
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

Eigen::Vector3d TipFriction::feedforward(const Contact& contact,
                                         const Eigen::Vector3d& v_WD) const noexcept {
  if (measured_ || settings_.feedforward <= 0.0 || contact.mode != ContactMode::contact)
    return Eigen::Vector3d::Zero();
  const Eigen::Vector3d v_d = v_WD - contact.v_K;
  const double speed = std::sqrt(v_d.squaredNorm() + settings_.fade_speed * settings_.fade_speed);
  return settings_.feedforward * contact.force / speed * v_d;
}

}  // namespace impedraw

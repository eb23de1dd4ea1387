#include "impedraw/control/normal_push.h"

#include <algorithm>

namespace impedraw {

NormalPush::NormalPush(const ImpedanceSettings& s) noexcept
    : dt_(s.timing.dt),
      settings_(s.force_integral),
      integrates_(s.force_integral.enabled && s.wrench == WrenchFeedback::measured) {}

Vector6 NormalPush::update(const Contact& contact, const Wrench& F_ext,
                           const Eigen::Vector3d& carried, bool frozen) noexcept {
  const Eigen::Vector3d& n = contact.n;
  const bool touches = contact.mode == ContactMode::contact;
  desired_ = touches ? contact.force : 0.0;
  built_up_ = touches ? std::max(0.0, desired_ - n.dot(carried)) : 0.0;
  if (integrates_ && !frozen) {
    const double asked = desired_ * n.dot(contact.n_C) - n.dot(carried);
    const double error = asked - n.dot(F_ext.head<3>());
    // Out of contact the integral's effect decays with the force carried over at the switch.
    integral_ = touches ? std::clamp(integral_ + settings_.rate * dt_ * error, -settings_.limit,
                                     settings_.limit)
                        : 0.0;
  }
  Vector6 F = Vector6::Zero();
  if (contact.on_surface()) F.head<3>() = -(desired_ * n.dot(contact.n_C) + integral_) * n;
  return F;
}

}  // namespace impedraw

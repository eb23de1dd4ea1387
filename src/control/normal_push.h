// The push F_n (Contact::force) of the pen along the normal, with a slow integral of its error.
//
// Law       F_push = −(F_n n·n_C + I) n,  in approach without F_n, away from the surface 0
//           İ = rate (asked − n·F_ext),  |I| ≤ limit;  I = 0 out of contact
// n·n_C     keeps the force along the normal where the ball touches at F_n (felt_normal.h).
// F_n       follows in contact what is asked for, by `fastest` a step at most: torques at the limit
//           of their rate lag behind the contact, and its force swings.
// asked     F_n n·n_C less what the handover holds back while the push builds up: the error is that
//           of the present push, and the integral does not wind up.
// Requires  a measured wrench for the integral
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "impedraw/control/contact.h"
#include "impedraw/control/tip_impedance.h"

namespace impedraw {

// Change of the push in a step that takes half of what the torques' rates allow [N].
inline double fastest_push(const ArmTerms& arm, const OperationalSpace& space,
                           const TipImpedance& impedance, const ImpedanceSettings& s,
                           const Eigen::Vector3d& n) noexcept {
  constexpr double kShare = 0.5;
  const Eigen::VectorXd& rate = s.limits.torque_rate;
  if (rate.size() == 0) return std::numeric_limits<double>::infinity();
  Vector6 newton = Vector6::Zero();
  newton.head<3>() = n;
  const JointVector by = arm.J.transpose().lazyProduct(impedance.to_arm(space, newton));
  return kShare * s.timing.dt / by.cwiseAbs().cwiseQuotient(rate).maxCoeff();
}

class NormalPush {
 public:
  explicit NormalPush(const ImpedanceSettings& s) noexcept
      : dt_(s.timing.dt),
        settings_(s.force_integral),
        integrates_(s.force_integral.enabled && s.wrench == WrenchFeedback::measured) {}

  // Integrates the force error over one step, unless `frozen`, and returns F_push [N, Nm].
  // carried: force that the handover adds in this step [N]. fastest: change of F_n in a step [N].
  Vector6 update(const Contact& contact, const Wrench& F_ext, const Eigen::Vector3d& carried,
                 bool frozen, double fastest) noexcept {
    const Eigen::Vector3d& n = contact.n;
    const bool touches = contact.mode == ContactMode::contact, touched = desired_ > 0.0;
    const double way = contact.force - desired_;
    if (!touches)
      desired_ = 0.0;
    else if (!touched || std::abs(way) <= fastest)
      desired_ = contact.force;
    else
      desired_ += std::copysign(fastest, way);
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

  double desired() const noexcept { return desired_; }    // F_n in contact, else 0 [N]
  double built_up() const noexcept { return built_up_; }  // the part that acts already [N]
  void reset() noexcept { integral_ = desired_ = 0.0; }

 private:
  double dt_;
  ForceIntegralSettings settings_;
  bool integrates_;
  double integral_ = 0.0, desired_ = 0.0, built_up_ = 0.0;  // [N]
};

}  // namespace impedraw

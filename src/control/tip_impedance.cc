#include "impedraw/control/tip_impedance.h"

#include <cmath>

namespace impedraw {

TipImpedance::TipImpedance(const ImpedanceSettings& s) noexcept
    : settings_(s),
      shaped_(s.inertia == InertiaShaping::shaped),
      scale_(s.inertia == InertiaShaping::scaled ? s.inertia_scale : 1.0),
      mobility_(s.shaped_inertia.inverse()) {
  retune(s.stiffness);
}

void TipImpedance::retune(const TipGain& stiffness) noexcept {
  settings_.stiffness = stiffness;
  K_damping_ = settings_.damping_stiffness();
  damping_ = diagonal_damping(K_damping_, settings_.shaped_inertia, settings_.damping_ratio);
  follow_ = damping_.inverse();
}

void TipImpedance::update(const OperationalSpace& space, const Eigen::Vector3d& n_W) noexcept {
  n_ = n_W;
  if (shaped_) return;
  modal_.design(space.inverse_inertia_factor(), K_damping_.linear.matrix(n_),
                K_damping_.angular.matrix(n_), settings_.damping_ratio);
  const double rate = modal_.largest_rate() / std::sqrt(scale_);
  at_limit_ = rate * settings_.timing.damping_delay() >= kDampingLimit;
}

Vector6 TipImpedance::damp(const OperationalSpace& space, const Vector6& V) const noexcept {
  if (shaped_) return damping_.apply(n_, V);
  return std::sqrt(scale_) * modal_.apply(space.inertia_factor(), V);
}

Vector6 TipImpedance::follow(const OperationalSpace& space, const Vector6& F) const noexcept {
  if (shaped_) return follow_.apply(n_, F);
  return modal_.solve(space.inverse_inertia_factor(), F) / std::sqrt(scale_);
}

Vector6 TipImpedance::to_arm(const OperationalSpace& space, const Vector6& F) const noexcept {
  if (shaped_) return space.inertia() * mobility_.apply(n_, F);
  return F / scale_;
}

}  // namespace impedraw

#include "impedraw/control/tip_impedance.h"

#include <cmath>

namespace impedraw {

TipImpedance::TipImpedance(const ImpedanceSettings& s) noexcept
    : settings_(s),
      shaped_(s.inertia == InertiaShaping::shaped),
      scale_(s.inertia == InertiaShaping::scaled ? s.inertia_scale : 1.0),
      lighter_(s.inertia == InertiaShaping::light_normal ? 1.0 / std::sqrt(s.inertia_scale) - 1.0
                                                         : 0.0),
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
  factor_ = space.inverse_inertia_factor();
  factor_inverse_ = space.inertia_factor();
  if (lighter_ != 0.0) {
    factor_.topRows<3>() += lighter_ * n_ * (n_.transpose() * factor_.topRows<3>()).eval();
    factor_inverse_.leftCols<3>() -=
        lighter_ / (1.0 + lighter_) * (factor_inverse_.leftCols<3>() * n_).eval() * n_.transpose();
  }
  modal_.design(factor_, K_damping_.linear.matrix(n_), K_damping_.angular.matrix(n_),
                settings_.damping_ratio);
  const double rate = modal_.largest_rate() / std::sqrt(scale_);
  at_limit_ = rate * settings_.timing.damping_delay() >= kDampingLimit;
}

Vector6 TipImpedance::damp(const Vector6& V) const noexcept {
  if (shaped_) return damping_.apply(n_, V);
  return std::sqrt(scale_) * modal_.apply(factor_inverse_, V);
}

Vector6 TipImpedance::follow(const Vector6& F) const noexcept {
  if (shaped_) return follow_.apply(n_, F);
  return modal_.solve(factor_, F) / std::sqrt(scale_);
}

Vector6 TipImpedance::to_arm(const OperationalSpace& space, const Vector6& F) const noexcept {
  if (shaped_) return space.inertia() * mobility_.apply(n_, F);
  if (lighter_ == 0.0) return F / scale_;
  // Λ S⁻¹ Λ⁻¹ (S⁻¹ F)
  Vector6 out = F;
  out.head<3>() += lighter_ * n_.dot(F.head<3>()) * n_;
  out += lighter_ * space.inertia().leftCols<3>() * n_ *
         n_.dot((space.inverse_inertia().topRows<3>() * out).eval());
  return out;
}

}  // namespace impedraw

// Desired dynamics at the tip: inertia M_d, damping B and stiffness K of the law (1), and the force
// that gives the arm this inertia.
//
// M_d       shaped: diag(mass, inertia) in the surface frame; scaled, natural: c Λ;
//           light_normal: S Λ S, S = I − (1 − √c) n nᵀ
// B         from M_d and K', so that every mode has the damping ratio ζ: damping.h. If M_d = c Λ,
//           its C and A are 1/c of those for M_d = Λ.
//           That of S Λ S is designed with the factor S⁻¹ U.
// Mapping   F_act = Λ M_d⁻¹ F, which is F/c if M_d = c Λ                            (10)–(11)
// Requires  settings that ImpedanceSettings::validate() accepts; `space` updated for this posture,
//           and then update()
#pragma once

#include <cmath>

#include "impedraw/control/damping.h"
#include "impedraw/control/impedance_settings.h"

namespace impedraw {

class TipImpedance {
 public:
  explicit TipImpedance(const ImpedanceSettings& s) noexcept
      : settings_(s),
        shaped_(s.inertia == InertiaShaping::shaped),
        scale_(s.inertia == InertiaShaping::scaled ? s.inertia_scale : 1.0),
        lighter_(s.inertia == InertiaShaping::light_normal ? 1.0 / std::sqrt(s.inertia_scale) - 1.0
                                                           : 0.0),
        mobility_(s.shaped_inertia.inverse()) {
    retune(s.stiffness);
  }

  void retune(const TipGain& stiffness) noexcept {
    settings_.stiffness = stiffness;
    K_damping_ = settings_.damping_stiffness();
    damping_ = diagonal_damping(K_damping_, settings_.shaped_inertia, settings_.damping_ratio);
    follow_ = damping_.inverse();
  }  // K
  // Designs B for this posture and the normal n.
  void update(const OperationalSpace& space, const Eigen::Vector3d& n_W) noexcept {
    n_ = n_W;
    if (shaped_) return;
    factor_ = space.inverse_inertia_factor();
    factor_inverse_ = space.inertia_factor();
    if (lighter_ != 0.0) {
      factor_.topRows<3>() += lighter_ * n_ * (n_.transpose() * factor_.topRows<3>()).eval();
      factor_inverse_.leftCols<3>() -= lighter_ / (1.0 + lighter_) *
                                       (factor_inverse_.leftCols<3>() * n_).eval() * n_.transpose();
    }
    modal_.design(factor_, K_damping_.linear.matrix(n_), K_damping_.angular.matrix(n_),
                  settings_.damping_ratio);
    const double rate = modal_.largest_rate() / std::sqrt(scale_);
    at_limit_ = rate * settings_.timing.damping_delay() >= kDampingLimit;
  }

  const TipGain& stiffness() const noexcept { return settings_.stiffness; }  // K
  Vector6 damp(const Vector6& V) const noexcept {
    if (shaped_) return damping_.apply(n_, V);
    return std::sqrt(scale_) * modal_.apply(factor_inverse_, V);
  }  // B V
  Vector6 follow(const Vector6& F) const noexcept {
    if (shaped_) return follow_.apply(n_, F);
    return modal_.solve(factor_, F) / std::sqrt(scale_);
  }  // B⁻¹ F
  Vector6 to_arm(const OperationalSpace& space, const Vector6& F) const noexcept {
    if (shaped_) return space.inertia() * mobility_.apply(n_, F);
    if (lighter_ == 0.0) return F / scale_;
    // Λ S⁻¹ Λ⁻¹ (S⁻¹ F)
    Vector6 out = F;
    out.head<3>() += lighter_ * n_.dot(F.head<3>()) * n_;
    out += lighter_ * space.inertia().leftCols<3>() * n_ *
           n_.dot((space.inverse_inertia().topRows<3>() * out).eval());
    return out;
  }  // Λ M_d⁻¹ F

  // max eig(M_d⁻¹ B) (Δt + delay) ≥ kDampingLimit in this posture. False if shaped: the set-up has
  // checked that.
  bool at_limit() const noexcept { return at_limit_; }

 private:
  ImpedanceSettings settings_;
  bool shaped_;
  double scale_;       // c of M_d = c Λ
  double lighter_;     // 1/√c − 1 of S⁻¹ = I + (1/√c − 1) n nᵀ; 0: S = I
  TipGain K_damping_;  // K'
  TipGain mobility_, damping_, follow_;  // M_d⁻¹, B and B⁻¹ if shaped
  ModalDamping modal_;                   // B otherwise
  Matrix6 factor_, factor_inverse_;      // S⁻¹ U and its inverse
  Eigen::Vector3d n_ = Eigen::Vector3d::UnitZ();
  bool at_limit_ = false;
};

}  // namespace impedraw

// Desired dynamics at the tip: inertia M_d, damping B and stiffness K of the law (1), and the force
// that gives the arm this inertia.
//
// M_d       shaped: diag(mass, inertia) in the surface frame; scaled, natural: c Λ;
//           light_normal: S Λ S, S = I − (1 − √c) n nᵀ
// B         from M_d and K', so that every mode has the damping ratio ζ: damping.h. If M_d = c Λ,
//           its C and A are 1/c of those for M_d = Λ.
//           That of S Λ S is designed with the factor S⁻¹ U.
// Mapping   F_act = Λ M_d⁻¹ F, which is F/c if M_d = c Λ                            (10)–(11)
// Stiff     A share s of M_d⁻¹ and of B becomes that of the arm's own inertia: stiff_contact.h. B⁻¹
//           is then an upper bound, (1 − s) B⁻¹ + s B_Λ⁻¹.
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
  // Designs B for this posture and the normal n. own: s
  void update(const OperationalSpace& space, const Eigen::Vector3d& n_W,
              double own = 0.0) noexcept {
    n_ = n_W;
    own_ = own;
    at_limit_ = false;
    if (own_ > 0.0) {
      U_ = space.inverse_inertia_factor();
      U_inverse_ = space.inertia_factor();
      own_damping_.design(U_, K_damping_.linear.matrix(n_), K_damping_.angular.matrix(n_),
                          settings_.damping_ratio);
      at_limit_ = is_limit(own_damping_.largest_rate());
    }
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
    at_limit_ |= is_limit(modal_.largest_rate() / std::sqrt(scale_));
  }

  const TipGain& stiffness() const noexcept { return settings_.stiffness; }  // K
  Vector6 damp(const Vector6& V) const noexcept {
    const Vector6 F = shaped_ ? damping_.apply(n_, V)
                              : Vector6(std::sqrt(scale_) * modal_.apply(factor_inverse_, V));
    return own_ > 0.0 ? mixed(F, own_damping_.apply(U_inverse_, V)) : F;
  }  // B V
  Vector6 follow(const Vector6& F) const noexcept {
    const Vector6 V =
        shaped_ ? follow_.apply(n_, F) : Vector6(modal_.solve(factor_, F) / std::sqrt(scale_));
    return own_ > 0.0 ? mixed(V, own_damping_.solve(U_, F)) : V;
  }  // B⁻¹ F
  Vector6 to_arm(const OperationalSpace& space, const Vector6& F) const noexcept {
    const Vector6 F_act = as_set(space, F);
    return own_ > 0.0 ? mixed(F_act, F) : F_act;
  }  // Λ M_d⁻¹ F

  // max eig(M_d⁻¹ B) (Δt + delay) ≥ kDampingLimit in this posture. False if shaped, with s = 0: the
  // set-up has checked that.
  bool at_limit() const noexcept { return at_limit_; }

 private:
  bool is_limit(double rate) const noexcept {
    return rate * settings_.timing.damping_delay() >= kDampingLimit;
  }
  Vector6 mixed(const Vector6& set, const Vector6& own) const noexcept {
    return (1.0 - own_) * set + own_ * own;
  }
  // Λ M_d⁻¹ F with s = 0.
  Vector6 as_set(const OperationalSpace& space, const Vector6& F) const noexcept {
    if (shaped_) return space.inertia() * mobility_.apply(n_, F);
    if (lighter_ == 0.0) return F / scale_;
    // Λ S⁻¹ Λ⁻¹ (S⁻¹ F)
    Vector6 out = F;
    out.head<3>() += lighter_ * n_.dot(F.head<3>()) * n_;
    out += lighter_ * space.inertia().leftCols<3>() * n_ *
           n_.dot((space.inverse_inertia().topRows<3>() * out).eval());
    return out;
  }

  ImpedanceSettings settings_;
  bool shaped_;
  double scale_;       // c of M_d = c Λ
  double lighter_;     // 1/√c − 1 of S⁻¹ = I + (1/√c − 1) n nᵀ; 0: S = I
  TipGain K_damping_;  // K'
  TipGain mobility_, damping_, follow_;  // M_d⁻¹, B and B⁻¹ if shaped
  ModalDamping modal_;                   // B otherwise
  Matrix6 factor_, factor_inverse_;      // S⁻¹ U and its inverse
  double own_ = 0.0;                     // s
  ModalDamping own_damping_;             // B_Λ
  Matrix6 U_, U_inverse_;                // of B_Λ
  Eigen::Vector3d n_ = Eigen::Vector3d::UnitZ();
  bool at_limit_ = false;
};

}  // namespace impedraw

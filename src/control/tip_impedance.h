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

#include "impedraw/control/damping.h"
#include "impedraw/control/impedance_settings.h"

namespace impedraw {

class TipImpedance {
 public:
  explicit TipImpedance(const ImpedanceSettings& settings) noexcept;

  void retune(const TipGain& stiffness) noexcept;  // K
  // Designs B for this posture and the normal n.
  void update(const OperationalSpace& space, const Eigen::Vector3d& n_W) noexcept;

  const TipGain& stiffness() const noexcept { return settings_.stiffness; }        // K
  Vector6 damp(const Vector6& V) const noexcept;                                   // B V
  Vector6 follow(const Vector6& F) const noexcept;                                 // B⁻¹ F
  Vector6 to_arm(const OperationalSpace& space, const Vector6& F) const noexcept;  // Λ M_d⁻¹ F

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

// Point contact between the pen tip and the canvas, solved exactly for one time step: a
// spring-damper along the normal and exact, rigid Coulomb friction along the tangents.
//
//   v⁺   = v_free + G p                                       G = J M⁻¹ Jᵀ,  p = h f
//   f_n  = max(0, k φ − b v_n⁺)
//   v_t⁺ = 0 with |f_t| ≤ μ f_n,  or  f_t = −μ f_n v_t⁺/|v_t⁺|
//
// v⁺: velocity of the contact point after the step; φ: penetration at the start of the step. The
// damper acts on the new velocity.
//
// The explicit spring with an implicit damper follows the oscillator (k, b, m) within 1 % at 1 ms
// for this tip. It is stable for √(k/m) h < 2. MuJoCo's convex friction cone couples normal and
// tangential motion instead, and lifts a sliding tip off (docs/decisions/0002).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/simulation/world_settings.h"

namespace impedraw {

// In the contact's frame: two tangents, then the outward normal.
struct TipContactStep {
  Eigen::Matrix3d G;       // Delassus matrix [1/kg]
  Eigen::Vector3d v_free;  // contact-point velocity after the step without this contact [m/s]
  double penetration;      // φ [m]
  double dt;               // h [s]
};

inline constexpr int kTipContactSweeps = 500;  // maximum, for a sliding tip

struct TipImpulse {
  Eigen::Vector3d p;      // h f on the tip [N s]; zero if it is out of contact or separating
  bool converged = true;  // false: stopped after kTipContactSweeps
};

// R_WC of the contact's frame.
inline Eigen::Matrix3d contact_frame(const Eigen::Vector3d& n) {
  Eigen::Matrix3d R;
  R.col(2) = n;
  R.col(0) = n.unitOrthogonal();
  R.col(1) = n.cross(R.col(0));
  return R;
}

// For a sliding tip, the iteration starts from `guess`.
TipImpulse solve_tip_contact(const TipContactStep& step, const TipMaterial& tip,
                             const Eigen::Vector3d& guess = Eigen::Vector3d::Zero()) noexcept;

}  // namespace impedraw

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

#include "impedraw/common/range.h"

namespace impedraw {

struct TipMaterial {
  double radius = 1.0e-3;     // of the tip sphere [m]
  double stiffness = 20.0e3;  // k [N/m]
  double damping = 60.0;      // b [N s/m]
  double friction = 0.3;      // μ
  // Along the line (tip_line.h)
  double friction_change = 0.0;   // a, a share of μ
  double friction_length = 0.02;  // L [m]
  double wear = 0.0;              // k, length per work of a tangential force f_n [m/(N m)]

  struct Limits {
    static constexpr Limit radius = {"radius", "m", {1e-5, 0.05}};
    static constexpr Limit stiffness = {"stiffness", "N/m", {10.0, 1e7}};
    static constexpr Limit damping = {"damping", "N s/m", {0.0, 1e5}};
    static constexpr Limit friction = {"friction", "", {0.0, 3.0}};
    static constexpr Limit friction_change = {"friction_change", "", {0.0, 1.0}};
    static constexpr Limit friction_length = {"friction_length", "m", {1e-3, 10.0}};
    static constexpr Limit wear = {"wear", "m/(N m)", {0.0, 0.01}};
  };
};

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

// For a sliding tip, the iteration starts from `guess`.
TipImpulse solve_tip_contact(const TipContactStep& step, const TipMaterial& tip,
                             const Eigen::Vector3d& guess = Eigen::Vector3d::Zero()) noexcept;

}  // namespace impedraw

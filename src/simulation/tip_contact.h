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

#include <algorithm>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "impedraw/simulation/world_settings.h"

namespace impedraw {

inline Eigen::Vector2d within_cone(const Eigen::Vector2d& p_t, double limit) {
  const double size = p_t.norm();
  return size > limit ? Eigen::Vector2d(p_t * (limit / size)) : p_t;
}

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
inline TipImpulse solve_tip_contact(
    const TipContactStep& s, const TipMaterial& tip,
    const Eigen::Vector3d& guess = Eigen::Vector3d::Zero()) noexcept {
  if (s.penetration <= 0.0) return {Eigen::Vector3d::Zero()};
  const double hb = s.dt * tip.damping, spring = s.dt * tip.stiffness * s.penetration;
  const Eigen::Matrix2d G_tt = s.G.topLeftCorner<2, 2>();
  const Eigen::Vector2d G_tn = s.G.topRightCorner<2, 1>();
  const double G_nn = s.G(2, 2);
  const double denominator = 1.0 + hb * G_nn;
  const auto normal_impulse = [&](const Eigen::Vector2d& p_t) {
    return std::max(0.0, (spring - hb * (s.v_free[2] + G_tn.dot(p_t))) / denominator);
  };
  if (tip.friction <= 0.0) return {{0.0, 0.0, normal_impulse(Eigen::Vector2d::Zero())}};

  // Stuck: three linear equations.
  Eigen::Matrix3d A = s.G;
  A.row(2) *= hb;
  A(2, 2) += 1.0;
  const Eigen::Vector3d rhs(-s.v_free[0], -s.v_free[1], spring - hb * s.v_free[2]);
  const Eigen::Vector3d stuck = A.inverse() * rhs;
  if (stuck.head<2>().norm() <= tip.friction * stuck[2]) return {stuck};

  // Sliding: projected Gauss-Seidel between the normal and the friction disc.
  const double trace = G_tt.trace(), det = G_tt.determinant();
  const double largest = 0.5 * trace + std::sqrt(std::max(0.0, 0.25 * trace * trace - det));
  Eigen::Vector2d p_t = guess.head<2>();
  double p_n = normal_impulse(p_t);
  bool converged = false;
  for (int i = 0; i < kTipContactSweeps && !converged; ++i) {
    const Eigen::Vector2d v_t = s.v_free.head<2>() + G_tt * p_t + G_tn * p_n;
    const Eigen::Vector2d next = within_cone(p_t - v_t / largest, tip.friction * p_n);
    const double p_n_next = normal_impulse(next);
    const double change = (next - p_t).cwiseAbs().maxCoeff() + std::abs(p_n_next - p_n);
    p_t = next;
    p_n = p_n_next;
    converged = change < 1e-13 * (1.0 + p_n);
  }
  return {{p_t[0], p_t[1], p_n}, converged};
}

}  // namespace impedraw

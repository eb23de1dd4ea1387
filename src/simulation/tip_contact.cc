#include "impedraw/simulation/tip_contact.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace impedraw {

namespace {

Eigen::Vector2d within_cone(const Eigen::Vector2d& p_t, double limit) {
  const double size = p_t.norm();
  return size > limit ? Eigen::Vector2d(p_t * (limit / size)) : p_t;
}

}  // namespace

TipImpulse solve_tip_contact(const TipContactStep& s, const TipMaterial& tip,
                             const Eigen::Vector3d& guess) noexcept {
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
  if (stuck[2] > 0.0 && stuck.head<2>().norm() <= tip.friction * stuck[2]) return {stuck};

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

// A planned motion that is carried by a moving surface: feed-forward for a canvas that moves.
//
// The plan lives in the canvas's frame K. Where K moves in W, the tip's desired motion is
//
//   p = X_WK p_K                    r = R_WK p_K
//   v = v_K0 + ω × r + R v_K
//   a = a_K0 + α × r + ω × (ω × r) + 2 ω × R v_K + R a_K
//
// and n = R n_K turns with Ω = ω + R ω_K, of which TipReference holds the part across n:
//
//   ω_D = Ω − (Ω·n) n               α_D = n × (Ω̇ × n + Ω × (Ω × n)),  Ω̇ = α + ω × R ω_K + R α_K
#pragma once

#include "impedraw/common/pose.h"
#include "impedraw/control/surface_estimate.h"
#include "impedraw/control/tip_reference.h"

namespace impedraw {

// Motion of K in W at one instant; of its origin, and as a whole.
struct FrameMotion {
  Pose X_WK;
  Eigen::Vector3d v = Eigen::Vector3d::Zero();      // of K's origin [m/s]
  Eigen::Vector3d a = Eigen::Vector3d::Zero();      // of K's origin [m/s²]
  Eigen::Vector3d w = Eigen::Vector3d::Zero();      // angular velocity [rad/s]
  Eigen::Vector3d alpha = Eigen::Vector3d::Zero();  // angular acceleration [rad/s²]

  // Velocity of the point of K that is at p_W [m/s].
  Eigen::Vector3d velocity_at(const Eigen::Vector3d& p_W) const noexcept {
    return v + w.cross(p_W - X_WK.p);
  }
  Eigen::Vector3d acceleration_at(const Eigen::Vector3d& p_W) const noexcept {
    const Eigen::Vector3d r = p_W - X_WK.p;
    return a + alpha.cross(r) + w.cross(w.cross(r));
  }
};

// A reference whose members are given in K, as it is in W. Allocates nothing.
inline TipReference carried(const TipReference& in_K, const FrameMotion& motion) noexcept {
  const Eigen::Matrix3d& R = motion.X_WK.R;
  const Eigen::Vector3d r = R * in_K.p_WD, v = R * in_K.v_WD;
  const Eigen::Vector3d turn = R * in_K.w_WD;
  TipReference out = in_K;
  out.p_WD = motion.X_WK.p + r;
  out.v_WD = motion.v + motion.w.cross(r) + v;
  out.a_WD = motion.a + motion.alpha.cross(r) + motion.w.cross(motion.w.cross(r)) +
             2.0 * motion.w.cross(v) + R * in_K.a_WD;
  const Eigen::Vector3d n = R * in_K.n_WD;
  const Eigen::Vector3d total = motion.w + turn;
  const Eigen::Vector3d total_rate = motion.alpha + motion.w.cross(turn) + R * in_K.alpha_WD;
  out.n_WD = n;
  out.w_WD = total - total.dot(n) * n;
  out.x_WD = R * in_K.x_WD;
  out.yaw_rate = in_K.yaw_rate + n.dot(motion.w);
  out.alpha_WD = n.cross(total_rate.cross(n) + total.cross(total.cross(n)));
  return out;
}

// The same of an estimate: distances stay.
inline SurfaceEstimate carried(SurfaceEstimate in_K, const FrameMotion& motion) noexcept {
  in_K.n_W = motion.X_WK.R * in_K.n_W;
  return in_K;
}

}  // namespace impedraw

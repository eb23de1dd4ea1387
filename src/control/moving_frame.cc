#include "impedraw/control/moving_frame.h"

namespace impedraw {

using Eigen::Vector3d;

TipReference carried(const TipReference& in_K, const FrameMotion& motion) noexcept {
  const Eigen::Matrix3d& R = motion.X_WK.R;
  const Vector3d r = R * in_K.p_WD, v = R * in_K.v_WD;
  const Vector3d turn = R * in_K.w_WD;
  TipReference out = in_K;
  out.p_WD = motion.X_WK.p + r;
  out.v_WD = motion.v + motion.w.cross(r) + v;
  out.a_WD = motion.a + motion.alpha.cross(r) + motion.w.cross(motion.w.cross(r)) +
             2.0 * motion.w.cross(v) + R * in_K.a_WD;
  const Vector3d n = R * in_K.n_WD;
  const Vector3d total = motion.w + turn;
  const Vector3d total_rate = motion.alpha + motion.w.cross(turn) + R * in_K.alpha_WD;
  out.n_WD = n;
  out.w_WD = total - total.dot(n) * n;
  out.x_WD = R * in_K.x_WD;
  out.yaw_rate = in_K.yaw_rate + n.dot(motion.w);
  out.alpha_WD = n.cross(total_rate.cross(n) + total.cross(total.cross(n)));
  return out;
}

}  // namespace impedraw

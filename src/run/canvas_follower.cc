#include "impedraw/run/canvas_follower.h"

#include <algorithm>

namespace impedraw {

TipReference CanvasFollower::in_world(const TipReference& reference) const noexcept {
  if (!joined()) return reference;
  TipReference out = carried(reference, estimate_.motion);
  const double u = std::clamp((time_ - joined_at_) / duration_, 0.0, 1.0);
  if (u >= 1.0) return out;
  const double share = u * u * u * (10.0 + u * (6.0 * u - 15.0));
  const double rate = 30.0 * u * u * (1.0 - u) * (1.0 - u) / duration_;
  const double rise = 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (duration_ * duration_);
  const Eigen::Vector3d way = out.p_WD - from_.p_WD;
  out.a_WD = rise * way + 2.0 * rate * out.v_WD + share * out.a_WD;
  out.v_WD = rate * way + share * out.v_WD;
  out.p_WD = from_.p_WD + share * way;
  out.n_WD = ((1.0 - share) * from_.n_WD + share * out.n_WD).normalized();
  out.w_WD *= share;
  out.alpha_WD *= share;
  return out;
}

}  // namespace impedraw

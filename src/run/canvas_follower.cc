#include "impedraw/run/canvas_follower.h"

#include <algorithm>

#include "impedraw/common/minimum_jerk.h"

namespace impedraw {
namespace {

// From a to b, at u of 0 to 1 of the time.
TipReference between(const TipReference& a, const TipReference& b, double u, double duration) {
  const auto [share, rate, change] = MinimumJerk::at(u, duration);
  const Eigen::Vector3d way = b.p_WD - a.p_WD, faster = b.v_WD - a.v_WD;
  TipReference out = b;
  out.p_WD = a.p_WD + share * way;
  out.v_WD = a.v_WD + share * faster + rate * way;
  out.a_WD = a.a_WD + share * (b.a_WD - a.a_WD) + 2.0 * rate * faster + change * way;
  out.n_WD = ((1.0 - share) * a.n_WD + share * b.n_WD).normalized();
  out.w_WD = (1.0 - share) * a.w_WD + share * b.w_WD;
  out.alpha_WD = (1.0 - share) * a.alpha_WD + share * b.alpha_WD;
  return out;
}

}  // namespace

TipReference CanvasFollower::in_world(const TipReference& reference) const noexcept {
  const double since = time_ - (joined() ? joined_at_ : left_at_);
  const bool over = since >= duration_;
  if (joined()) {
    const TipReference out = carried(reference, estimate_.motion);
    return over ? out : between(from_, out, std::max(0.0, since / duration_), duration_);
  }
  if (over) return reference;
  const Pose X_KW = X_WK_left_.inverse();
  TipReference in_K = reference;
  in_K.p_WD = X_KW * reference.p_WD;
  for (Eigen::Vector3d TipReference::*member :
       {&TipReference::v_WD, &TipReference::a_WD, &TipReference::n_WD, &TipReference::w_WD,
        &TipReference::alpha_WD, &TipReference::x_WD})
    in_K.*member = X_KW.R * in_K.*member;
  return between(carried(in_K, estimate_.motion), reference, std::max(0.0, since / duration_),
                 duration_);
}

}  // namespace impedraw

#include "impedraw/experiment/pen_axis.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "impedraw/common/in_parallel.h"

namespace impedraw {

// In flat noise finer patches are in use, at most, in places.
bool is_rough(const Belief& belief, const Plan& plan) {
  constexpr double kOther = 0.02, kLeast = 0.1, kSpacing = 2e-3;  // [rad], [1], [m]
  if (!belief.perception) return false;
  const Pose& X_WP = plan.path_settings.X_WP;
  std::atomic<long> places = 0, other = 0;
  in_parallel(static_cast<int>(plan.strokes.size()), [&](int number) {
    const PlacedStroke& stroke = plan.strokes[static_cast<std::size_t>(number)];
    SurfaceHeight::Sample last;
    for (std::size_t i = 0; i < stroke.p_P.size(); ++i) {
      const Eigen::Vector2d to = stroke.p_P[i], from = i > 0 ? stroke.p_P[i - 1] : to;
      const int pieces = std::max(1, static_cast<int>(std::ceil((to - from).norm() / kSpacing)));
      for (int k = 1; k <= pieces; ++k) {
        const Eigen::Vector2d at = from + (to - from) * k / pieces;
        const auto sample = belief.surface(at.x(), at.y(), last);
        if (!sample) continue;
        const SurfaceEstimate there = belief.perception->estimate(X_WP * sample->p_P);
        ++places;
        other += there.status == SurfaceStatus::ok &&
                 there.n_W.cross(X_WP.R * sample->n_P).norm() > kOther;
      }
    }
  });
  return static_cast<double>(other) > kLeast * static_cast<double>(places);
}

}  // namespace impedraw

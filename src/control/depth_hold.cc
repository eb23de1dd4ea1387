#include "impedraw/control/depth_hold.h"

#include <algorithm>

namespace impedraw {

double DepthHold::force(const TipReference& reference, const Eigen::Vector3d& p_E,
                        const Eigen::Vector3d& n, double f_n, bool touches) noexcept {
  constexpr double kNear = 1e-4;   // distance that counts half as much as none [m]
  constexpr double kMoves = 1e-3;  // while it sinks in, at a line's start, nothing is wrong [m/s]
  if (!touches) {
    integral_ = 0.0;
    return reference.force;
  }
  if (!(reference.depth > 0.0)) {
    const Eigen::Vector3d p_S = p_E + std::max(0.0, f_n) / cut_.stiffness * n;
    if (KeptPlace* const place = touched_.at(p_S)) {
      place->value += 1.0;
      place->p += (p_S - place->p) / place->value;
    }
    return reference.force;
  }
  double sum = 0.0, weights = 0.0;
  touched_.around(p_E + reference.depth * n, [&](const KeptPlace& place) {
    const Eigen::Vector3d to = place.p - p_E;
    const double depth = n.dot(to);
    const double weight = 1.0 / (kNear * kNear + (to - depth * n).squaredNorm());
    sum += weight * depth;
    weights += weight;
  });
  if (weights > 0.0 && reference.v_WD.norm() > kMoves) {
    const double most = kShare * reference.force;
    const double harder = reference.force / (reference.force + integral_);
    const double depth = sum / weights - cut_.score * (1.0 - harder);
    integral_ += kRate * cut_.stiffness * dt_ * (reference.depth - depth);
    integral_ = std::clamp(integral_, -most, most);
  }
  return reference.force + integral_;
}

}  // namespace impedraw

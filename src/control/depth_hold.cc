#include "impedraw/control/depth_hold.h"

#include <algorithm>
#include <cmath>

namespace impedraw {

void DepthHold::touch(const Eigen::Vector3d& p_E, const Eigen::Vector3d& n, double f_n) noexcept {
  const Eigen::Vector3d p_S = p_E + std::max(0.0, f_n) / cut_.stiffness * n;
  if (KeptPlace* const place = touched_.at(p_S)) {
    place->value += 1.0;
    place->p += (p_S - place->p) / place->value;
  }
}

double DepthHold::force(const TipReference& reference, const Eigen::Vector3d& p_E,
                        const Eigen::Vector3d& n, double f_n, bool touches) noexcept {
  constexpr double kNear = 1e-4;                    // distance that counts half as much as none [m]
  constexpr double kSoftest = 0.3, kHardest = 3.0;  // h
  constexpr double kMoves = 1e-3;  // while it sinks in, at a line's start, nothing is wrong [m/s]
  if (!touches) {
    integral_ = 0.0;
    if (reference.depth > 0.0)
      integral_ = std::clamp(hardness_ - 1.0, -kLess, kMore) * reference.force;
    return reference.force + integral_;
  }
  if (!(reference.depth > 0.0)) {
    touch(p_E, n, f_n);
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
    const double deeper = sum / weights - cut_.score;  // Δ
    if (reference.depth < 1.01 * cut_.first && deeper > 0.0) {
      const double y = (cut_.first - cut_.score) * std::pow(1.0 + integral_ / reference.force,
                                                            1.2 + 0.8 * cut_.score / cut_.first);
      hardness_ += dt_ / (kLearn + dt_) * (std::clamp(y / deeper, kSoftest, kHardest) - hardness_);
    }
    const double depth = deeper + cut_.score / hardness_;
    integral_ += kRate * cut_.stiffness * dt_ * (reference.depth - depth);
    integral_ = std::clamp(integral_, -kLess * reference.force, kMore * reference.force);
  }
  return reference.force + integral_;
}

}  // namespace impedraw

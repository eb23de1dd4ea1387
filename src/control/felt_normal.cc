#include "impedraw/control/felt_normal.h"

#include <algorithm>
#include <cmath>

namespace impedraw {

Eigen::Vector3d friction_in(const Eigen::Vector3d& f_t, const Eigen::Vector3d& slip,
                            double most) noexcept {
  return -std::clamp(-f_t.dot(slip), 0.0, most) * slip;
}

void FeltNormal::update(const Eigen::Vector3d& n, const Eigen::Vector3d& f,
                        const Eigen::Vector3d& slip, double friction, double least_force) noexcept {
  constexpr double kTime = 5e-3;  // 0.25 mm at 50 mm/s: a quarter of the ball's radius [s]
  if (!in_use()) return;
  if (!known_) n_F_ = n;
  known_ = true;
  const double f_n = n.dot(f);
  if (f_n < least_force) return;
  const Eigen::Vector3d f_t = f - f_n * n;
  const Eigen::Vector3d aside = f_t - friction_in(f_t, slip, friction * f_n);
  // At rest the spring's own pull would be taken for a slope.
  const Eigen::Vector3d x = (n + slip.norm() / f_n * aside).normalized();
  n_F_ = (n_F_ + std::min(1.0, dt_ / kTime) * (x - n_F_)).normalized();
  deviation_ = settings_.deviation + settings_.force_error / f_n;
}

Eigen::Vector3d FeltNormal::beyond(const Eigen::Vector3d& m) const noexcept {
  constexpr double kMost = 1.0, kLeastCosine = 0.1;
  if (!known_) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d tangent = n_F_ / std::max(n_F_.dot(m), kLeastCosine);
  const Eigen::Vector3d aside = tangent - m * m.dot(tangent);
  const double size = aside.norm();
  return aside * (std::clamp(size - deviation_, 0.0, kMost) / std::max(size, 1e-9));
}

Eigen::Vector3d FeltNormal::seen_from(const Eigen::Vector3d& n) const noexcept {
  return (n + beyond(n)).normalized();
}

Eigen::Vector3d FeltNormal::corrected(const Eigen::Vector3d& perceived) const noexcept {
  return (perceived + settings_.share * beyond(perceived)).normalized();
}

}  // namespace impedraw

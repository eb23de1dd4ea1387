// The ends of the joints' ranges, and the speeds with which joints may move towards them.
//
// Speed    |v_j| ≤ min(limit_j, kStopRate (d − kShortOfEnd) + kCreep), d: distance to the end of
//          the range ahead. A joint comes to rest kShortOfEnd before it, with the time constant
//          1/kStopRate, and creeps on.
// Margin   depth (margin − d)/margin in the margin of either end: 0 outside, 1 at the end
#pragma once

#include <algorithm>
#include <limits>

#include "impedraw/control/impedance_settings.h"

namespace impedraw {

class JointRange {
 public:
  static constexpr double kShortOfEnd = 0.015;  // [rad]
  static constexpr double kStopRate = 8.0;      // [1/s]
  static constexpr double kCreep = 5e-3;        // [rad/s]

  // Depth in the margins of the lower and the upper end.
  struct Depth {
    double lower = 0.0, upper = 0.0;
  };

  explicit JointRange(const ImpedanceSettings& settings)
      : lower_(settings.joint_range.lower),
        upper_(settings.joint_range.upper),
        speed_(settings.limits.joint_speed),
        margin_(settings.joint_range.margin) {}

  // Number of joints with a range, and with a speed limit: all or none.
  Eigen::Index ranges() const noexcept { return lower_.size(); }
  Eigen::Index speeds() const noexcept { return speed_.size(); }

  Depth depth(const JointVector& q, Eigen::Index j) const noexcept {
    const double above = margin_ - (q[j] - lower_[j]), below = margin_ - (upper_[j] - q[j]);
    if (above <= 0.0 && below <= 0.0) return {};
    return {std::max(0.0, above) / margin_, std::max(0.0, below) / margin_};
  }

  // Distance of the joint that is nearest to an end of its range [rad].
  double room(const JointVector& q) const noexcept {
    if (ranges() == 0) return std::numeric_limits<double>::infinity();
    return std::min((q - lower_).minCoeff(), (upper_ - q).minCoeff());
  }

  // Highest speed of joint j at q in the direction of v, if it has a limit [rad/s].
  double most_speed(const JointVector& q, Eigen::Index j, double v) const noexcept {
    if (ranges() == 0) return speed_[j];
    const double room = v < 0.0 ? q[j] - lower_[j] : upper_[j] - q[j];
    return std::min(speed_[j], kCreep * std::clamp(room / kShortOfEnd, 0.0, 1.0) +
                                   kStopRate * std::max(0.0, room - kShortOfEnd));
  }

 private:
  JointVector lower_, upper_, speed_;  // [rad], [rad/s]; empty: none
  double margin_;                      // [rad]
};

}  // namespace impedraw

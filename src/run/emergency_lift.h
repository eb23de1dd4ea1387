// The end of a run that cannot continue: the pen lifts off along the surface normal and stays up.
#pragma once

#include <algorithm>

#include "impedraw/common/minimum_jerk.h"
#include "impedraw/common/pose.h"
#include "impedraw/control/tip_reference.h"

namespace impedraw {

class EmergencyLift {
 public:
  static constexpr double kDuration = 1.0;    // at least [s]
  static constexpr double kHeight = 0.03;     // [m]
  static constexpr double kMostSpeed = 0.35;  // [m/s]
  static constexpr double kAside = 0.1;       // [s]

  // Keeps the pen's axis as it is at X_WE. aside_W: how far the pen moves across n_W meanwhile, in
  // the first kAside, while it has hardly risen [m].
  EmergencyLift(double start, const Pose& X_WE, const Eigen::Vector3d& n_W, double height = kHeight,
                const Eigen::Vector3d& aside_W = Eigen::Vector3d::Zero())
      : start_(start),
        height_(height),
        duration_(std::max(kDuration, 1.875 * height / kMostSpeed)),
        p_(X_WE.p),
        n_(n_W),
        aside_(aside_W),
        axis_(-X_WE.R.col(2)) {}

  double duration() const { return duration_; }
  bool done(double t) const { return t >= start_ + duration_; }
  // Way of the tip so far, along the normal [m].
  double risen(const Eigen::Vector3d& p_WE) const { return n_.dot(p_WE - p_); }
  // Minimum-jerk motion from rest to rest.
  TipReference at(double t) const {
    const MinimumJerk jerk =
        MinimumJerk::at(std::clamp((t - start_) / duration_, 0.0, 1.0), duration_);
    const MinimumJerk aside = MinimumJerk::at(std::clamp((t - start_) / kAside, 0.0, 1.0), kAside);
    TipReference reference;
    reference.n_WD = axis_;
    reference.p_WD = p_ + height_ * jerk.share * n_ + aside.share * aside_;
    reference.v_WD = height_ * jerk.rate * n_ + aside.rate * aside_;
    reference.a_WD = height_ * jerk.change * n_ + aside.change * aside_;
    return reference;
  }

 private:
  double start_, height_, duration_;
  Eigen::Vector3d p_, n_, aside_, axis_;
};

}  // namespace impedraw

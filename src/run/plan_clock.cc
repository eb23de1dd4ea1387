#include "impedraw/run/plan_clock.h"

#include <algorithm>
#include <cmath>

namespace impedraw {
namespace {

constexpr double kRiseFilter = 0.01;  // time constant [s]

double share(const YieldBounds& bounds, double x) {
  if (!(x > bounds.slow)) return 1.0;  // also if unknown
  return std::max(0.0, (bounds.stop - x) / (bounds.stop - bounds.slow));
}

}  // namespace

void PlanClock::advance(const PenDeviation& pen) noexcept {
  const double force = std::isfinite(pen.force) ? pen.force : 0.0;
  force_ += (force - force_) * dt_ / (settings_.force_filter + dt_);
  const double normal_speed = std::isfinite(pen.normal_speed) ? pen.normal_speed : 0.0;
  normal_speed_squared_ += (normal_speed * normal_speed - normal_speed_squared_) * dt_ /
                           (settings_.normal_speed_filter + dt_);
  const double rise = (pen.joint - joint_) / dt_;
  joint_rise_ += (rise - joint_rise_) * dt_ / (kRiseFilter + dt_);
  joint_ = pen.joint;
  const double joint = pen.joint + settings_.foresight * std::max(0.0, joint_rise_);
  double desired = std::min({share(settings_.tip, pen.tip), share(settings_.tilt, pen.tilt),
                             share(settings_.force, std::abs(force_)),
                             share(settings_.normal_speed, std::sqrt(normal_speed_squared_)),
                             share(settings_.joint, joint)});
  desired = std::min(desired, pen.limit);
  if (pen.waits) desired = 0.0;
  if (!pen.paused) {
    stood_ = desired < settings_.least ? stood_ + dt_ : std::max(0.0, stood_ - dt_);
    if (stood_ > settings_.patience) desired = std::max(desired, settings_.least);
  } else {
    desired = 0.0;
  }
  const double next =
      std::clamp(desired, rate_ - settings_.slow_down * dt_, rate_ + settings_.speed_up * dt_);
  slope_ = (next - rate_) / dt_;
  lag_ += dt_ * (1.0 - 0.5 * (rate_ + next));
  rate_ = next;
}

TipReference PlanClock::scaled(TipReference reference) const noexcept {
  if (rate_ == 1.0 && slope_ == 0.0) return reference;
  reference.a_WD = rate_ * rate_ * reference.a_WD + slope_ * reference.v_WD;
  reference.alpha_WD = rate_ * rate_ * reference.alpha_WD + slope_ * reference.w_WD;
  reference.yaw_acceleration =
      rate_ * rate_ * reference.yaw_acceleration + slope_ * reference.yaw_rate;
  reference.yaw_rate *= rate_;
  reference.v_WD *= rate_;
  reference.force_rate *= rate_;
  reference.w_WD *= rate_;
  return reference;
}

}  // namespace impedraw

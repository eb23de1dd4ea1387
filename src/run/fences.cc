#include "impedraw/run/fences.h"

#include <fmt/format.h>

#include "impedraw/common/errors.h"

namespace impedraw {

Fences::Fences(const FenceSettings& settings, bool measured) : settings_(settings) {
  for (int i = 0; i < 3; ++i)
    if (!(settings.low[i] < settings.high[i]))
      throw InputError(fmt::format(
          "fence.low: {} m along {} is not below fence.high, {} m: the box holds no point",
          settings.low[i], "xyz"[i], settings.high[i]));
  if (settings.force && !measured)
    throw InputError(
        "fence.force: nothing measures the force with control.wrench none; valid is null, or "
        "another control.wrench");
}

bool Fences::update(const Eigen::Vector3d& p_WE, const Eigen::Vector3d& v_WE,
                    const Eigen::Vector3d& f, double dt) noexcept {
  if (kind_ != Kind::none) return false;
  for (int i = 0; i < 3; ++i) {
    if (!(p_WE[i] < settings_.low[i] || p_WE[i] > settings_.high[i])) continue;
    kind_ = Kind::box;
    axis_ = i;
    value_ = p_WE[i];
    return true;
  }
  const double force = f.norm(), speed = v_WE.norm();
  force_above_ = settings_.force && force > *settings_.force ? force_above_ + dt : 0.0;
  speed_above_ = settings_.speed && speed > *settings_.speed ? speed_above_ + dt : 0.0;
  // A count of cycles, whatever the rounding of their sum.
  const double confirm = kConfirm - 0.5 * dt;
  if (force_above_ >= confirm) {
    kind_ = Kind::force;
    value_ = force;
  } else if (speed_above_ >= confirm) {
    kind_ = Kind::speed;
    value_ = speed;
  }
  return kind_ != Kind::none;
}

std::string Fences::crossed() const {
  switch (kind_) {
    case Kind::none:
      return {};
    case Kind::box:
      return fmt::format(
          "fence.{}: the tip's {} was {:.3f} m, the fence is {:.3f} m",
          value_ < settings_.low[axis_] ? "low" : "high", "xyz"[axis_], value_,
          value_ < settings_.low[axis_] ? settings_.low[axis_] : settings_.high[axis_]);
    case Kind::force:
      return fmt::format("fence.force: the force on the tip was {:.1f} N, the fence is {:.1f} N",
                         value_, *settings_.force);
    case Kind::speed:
      return fmt::format("fence.speed: the tip moved at {:.3f} m/s, the fence is {:.3f} m/s",
                         value_, *settings_.speed);
  }
  return {};
}

}  // namespace impedraw

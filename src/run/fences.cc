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

// With as many decimals as tell what was measured from the fence.
std::string Fences::crossed() const {
  const auto told = [](double value, double fence, int decimals, const char* unit) {
    while (decimals < 9 &&
           fmt::format("{:.{}f}", value, decimals) == fmt::format("{:.{}f}", fence, decimals))
      ++decimals;
    return fmt::format("{0:.{2}f} {3}, the fence is {1:.{2}f} {3}", value, fence, decimals, unit);
  };
  switch (kind_) {
    case Kind::none:
      return {};
    case Kind::box: {
      const bool low = value_ < settings_.low[axis_];
      return fmt::format("fence.{}: the tip's {} was {}", low ? "low" : "high", "xyz"[axis_],
                         told(value_, low ? settings_.low[axis_] : settings_.high[axis_], 3, "m"));
    }
    case Kind::force:
      return "fence.force: the force on the tip was " + told(value_, *settings_.force, 1, "N");
    case Kind::speed:
      return "fence.speed: the tip moved at " + told(value_, *settings_.speed, 3, "m/s");
  }
  return {};
}

}  // namespace impedraw

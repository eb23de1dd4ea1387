#include "impedraw/run/monitors/fence_monitor.h"

#include <optional>
#include <utility>

#include <fmt/format.h>

namespace impedraw {

FenceMonitor::FenceMonitor(const FenceSettings& settings, bool measured) : settings_(settings) {
  for (int i = 0; i < 3; ++i)
    if (!(settings.low[i] < settings.high[i]))
      throw InputError(fmt::format(
          "fence.low: {} m along {} is not below fence.high, {} m: the box holds no point",
          settings.low[i], "xyz"[i], settings.high[i]));
  for (const auto& [name, given] :
       {std::pair("force", &settings.force), {"moment", &settings.moment}})
    if (*given && !measured)
      throw InputError(fmt::format(
          "fence.{0}: nothing measures the {0} with control.wrench none; valid is null, or another "
          "control.wrench",
          name));
  if (!measured) return;
  if (!settings_.force) settings_.force = kForce;
  if (!settings_.moment) settings_.moment = kMoment;
}

bool FenceMonitor::update(const Eigen::Vector3d& p_WE, const Eigen::Vector3d& v_WE,
                          const Eigen::Vector3d& f, double dt, const Eigen::Vector3d& m,
                          double lag) noexcept {
  if (kind_ != Kind::none) return false;
  for (int i = 0; i < 3; ++i) {
    if (!(p_WE[i] < settings_.low[i] || p_WE[i] > settings_.high[i])) continue;
    kind_ = Kind::box;
    axis_ = i;
    value_ = p_WE[i];
    return true;
  }
  const auto judge = [&](Kind kind, double value, const std::optional<double>& fence,
                         double confirm, double* above) {
    *above = fence && value > *fence ? *above + dt : 0.0;
    // A count of cycles, whatever the rounding of their sum.
    if (kind_ != Kind::none || *above < confirm - 0.5 * dt) return;
    kind_ = kind;
    value_ = value;
  };
  judge(Kind::force, f.norm(), settings_.force, kConfirm, &force_above_);
  judge(Kind::moment, m.norm(), settings_.moment, kConfirm, &moment_above_);
  judge(Kind::speed, v_WE.norm(), settings_.speed, kConfirm, &speed_above_);
  judge(Kind::lag, lag, settings_.lag, kConfirmLag, &lag_above_);
  return kind_ != Kind::none;
}

Verdict FenceMonitor::judge(const Cycle& cycle) {
  if (!update(cycle.arm.X_WE.p, cycle.arm.V_WE.head<3>(), cycle.F_ext.head<3>(), cycle.dt,
              cycle.F_ext.tail<3>(), cycle.lag().norm()))
    return {};
  return {Severity::halt, fmt::format("{} at t = {:.3f} s", crossed(), cycle.run_time)};
}

// With as many decimals as tell what was measured from the fence.
std::string FenceMonitor::crossed() const {
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
    case Kind::moment:
      return "fence.moment: the moment at the tip was " + told(value_, *settings_.moment, 1, "Nm");
    case Kind::lag:
      return "fence.lag: the tip's distance from the point that it was driven to was " +
             told(value_, settings_.lag, 3, "m");
    case Kind::speed:
      return "fence.speed: the tip moved at " + told(value_, *settings_.speed, 3, "m/s");
  }
  return {};
}

}  // namespace impedraw

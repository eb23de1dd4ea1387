// Limits that make a plan slow, and places where the surface is rougher than the cameras resolve.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "impedraw/experiment/experiment.h"

namespace impedraw {

// A stroke that is drawn slower than this on average crawls [m/s].
inline constexpr double kCrawl = 0.015;

struct LimitCost {
  std::string limit;   // the settings that rule: "path.normal_acceleration"
  double seconds = 0;  // that the plan takes longer for it
  int stroke = -1;     // that it costs most
  double stroke_seconds = 0;
};

// A place on a stroke where the surface is rougher than perception knows it.
struct RoughPlace {
  Roughness roughness;
  int stroke = -1;
  Eigen::Vector2d page_mm = Eigen::Vector2d::Zero();
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
};

struct PlanLimits {
  std::vector<LimitCost> costs;  // of limits that cost more than 1 % of the plan's time
  std::vector<int> crawling;     // strokes of the plan
  double rough_share = 0.0;      // of the length to draw
  RoughPlace roughest;
};

// Rougher than the cameras resolve: the normal errs by more than 6°, and by more than noise
// explains.
bool is_unresolved(const Roughness& roughness) noexcept;

// Plans the path again with each limit lifted in turn; the drawing does not change.
PlanLimits plan_limits(const PlannedDrawing& drawing);

// Lines for the terminal; with `suggest`, also settings to try, each with its reason.
std::string plan_limits_text(const PlannedDrawing& drawing, const PlanLimits& limits, bool suggest);

nlohmann::ordered_json plan_limits_json(const PlanLimits& limits);

}  // namespace impedraw

// Summarises the pre-flight and the path of a drawing before anything moves.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "impedraw/experiment/experiment.h"
#include "impedraw/planning/preflight/preflight.h"
#include "impedraw/planning/wrap/distortion.h"

namespace impedraw {

// Ratios of lengths, areas and angles on the surface to those on the page.
Distortion projected_distortion(const PlannedDrawing& drawing);
Distortion wrapped_distortion(const PlannedDrawing& drawing);  // requires a wrapped drawing

double length_not_drawable(const PlannedDrawing& drawing);  // in the drawing plane [m]

// Length of the stroke as it is placed, flat: a wrapped one's is not that in the drawing plane [m].
double flat_length(const PlacedStroke& stroke, const Placement& placement);
// A part of one of plan.requested by the artwork's number, along the artwork's stroke.
StrokePart on_artwork(const Plan& plan, const Placement& placement, const StrokePart& part);

// strokes, drawable_parts, pen_down_m, pen_up_m, page_size_mm [x, y] of the strokes on the page,
// size_mm, the same on the canvas as seen along the drawing axis, notes (notes_of()), time_s,
// distortion, margins, not_drawable: [{stroke, from_mm, to_mm, problem, text, page_mm, world_m}].
nlohmann::ordered_json plan_json(const PlannedDrawing& drawing);

// The same as text.
std::string plan_text(const PlannedDrawing& drawing);

// Pre-flight findings as text. Strokes have the artwork's numbers.

// Names the stroke, the part of it, the problem, its size and its location.
std::string finding_text(const Finding& finding);

// The same, as the error message of a refused drawing. `seen`: the surface was seen by cameras.
std::string refusal_text(const Finding& finding, bool seen);

// Limits that make a plan slow, and places where the surface is rougher than the cameras resolve.

// A stroke that is drawn slower than this on average crawls [m/s].
inline constexpr double kCrawl = 0.015;

struct LimitCost {
  std::string limit;   // what rules: "path.normal_acceleration"
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

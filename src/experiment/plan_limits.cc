#include "impedraw/experiment/plan_limits.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/planning/preflight/joint_rates.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {

namespace {

constexpr double kSpacing = 2e-3;      // of places that are looked at [m]
constexpr double kLeastShare = 0.01;   // of the plan's time
constexpr double kUnresolved = 0.10;   // error of the normal [rad]
constexpr double kLeastMisfit = 3e-5;  // [m]
constexpr double kFree = 1e3;          // no limit, in SI units

struct Lifted {
  const char* limit;
  void (*lift)(PathSettings&);
};
constexpr Lifted kLimits[] = {
    {"path.normal_acceleration", [](PathSettings& s) { s.normal_acceleration = 100.0; }},
    {"path.normal_speed", [](PathSettings& s) { s.normal_speed = 1.0; }},
    {"path.tilt_speed and tilt_acceleration",
     [](PathSettings& s) { s.tilt_speed = 20.0, s.tilt_acceleration = kFree; }},
    {"path.joint_speed_share, joint_acceleration and joint_torque_share",
     [](PathSettings& s) {
       s.joint_speed_share = s.joint_torque_share = 1.0, s.joint_acceleration = kFree;
     }},
    {"path.draw_acceleration", [](PathSettings& s) { s.draw_acceleration = 20.0; }},
};

TipPath path_with(const PlannedDrawing& e, const PathSettings& settings) {
  return plan_from(settings, e.surface(), e.plan.strokes, e.scenario.arm.start_p_WE,
                   e.artwork.X_WP.R.col(2), settings.start_hold,
                   stroke_limits(e.belief, e.plan, settings));
}

std::string stroke_list(const std::vector<int>& strokes) {
  constexpr std::size_t kListed = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(kListed, strokes.size()); ++i)
    text += fmt::format("{}{}", i ? ", " : "", strokes[i]);
  return strokes.size() > kListed ? text + fmt::format(" and {} more", strokes.size() - kListed)
                                  : text;
}

}  // namespace

bool is_unresolved(const Roughness& r) noexcept {
  return r.slope > kUnresolved && r.misfit > kLeastMisfit;
}

PlanLimits plan_limits(const PlannedDrawing& e) {
  PlanLimits found;
  if (e.plan.strokes.empty()) return found;
  const TipPath& path = e.plan.path;
  for (const StrokeTimes& stroke : path.strokes())
    if (stroke.length > 5e-3 && stroke.length < kCrawl * (stroke.end - stroke.start))
      found.crawling.push_back(stroke.number);
  PathSettings free = e.plan.path_settings;
  for (const Lifted& lifted : kLimits) lifted.lift(free);
  const bool slowed =
      path.duration() - path_with(e, free).duration() > kLeastShare * path.duration();
  for (const Lifted& lifted : kLimits) {
    if (!slowed) break;
    PathSettings settings = e.plan.path_settings;
    lifted.lift(settings);
    const TipPath faster = path_with(e, settings);
    LimitCost cost{lifted.limit, path.duration() - faster.duration(), -1, 0.0};
    if (cost.seconds < kLeastShare * path.duration()) continue;
    for (std::size_t i = 0; i < path.strokes().size() && i < faster.strokes().size(); ++i) {
      const StrokeTimes &slow = path.strokes()[i], &fast = faster.strokes()[i];
      const double longer = (slow.end - slow.start) - (fast.end - fast.start);
      if (longer <= cost.stroke_seconds) continue;
      cost.stroke = slow.number;
      cost.stroke_seconds = longer;
    }
    found.costs.push_back(cost);
  }
  if (!e.belief.perception) return found;
  SurfaceHeight::Sample last;
  long places = 0, rough = 0;
  for (const PlacedStroke& stroke : e.plan.strokes) {
    const StrokeRuler ruler(stroke);
    const int pieces = std::max(1, static_cast<int>(std::ceil(ruler.length() / kSpacing)));
    for (int i = 0; i <= pieces; ++i) {
      const StrokePlace at = ruler.at(stroke.start + ruler.length() * i / pieces);
      const auto sample = e.surface()(at.p_P.x(), at.p_P.y(), last);
      if (!sample) continue;
      const Eigen::Vector3d p_W = e.artwork.X_WP * sample->p_P;
      const Roughness roughness = e.belief.perception->roughness(p_W);
      ++places;
      if (!is_unresolved(roughness)) continue;
      ++rough;
      if (roughness.misfit > found.roughest.roughness.misfit)
        found.roughest = {roughness, stroke.number, at.page, p_W};
    }
  }
  if (places > 0) found.rough_share = static_cast<double>(rough) / static_cast<double>(places);
  return found;
}

std::string plan_limits_text(const PlannedDrawing& e, const PlanLimits& limits, bool suggest) {
  std::string text;
  for (const LimitCost& cost : limits.costs)
    text += fmt::format("  slowed   {:.1f} s by {}, most on stroke {} ({:.1f} s)\n", cost.seconds,
                        cost.limit, cost.stroke, cost.stroke_seconds);
  if (!limits.crawling.empty())
    text += fmt::format("  crawling below {:.0f} mm/s: stroke{} {}\n", 1e3 * kCrawl,
                        limits.crawling.size() == 1 ? "" : "s", stroke_list(limits.crawling));
  if (limits.rough_share > 0.0) {
    const RoughPlace& at = limits.roughest;
    text += fmt::format(
        "  rough    {:.0f} % of the length is rougher than the cameras resolve, most at ({:.3f}, "
        "{:.3f}, {:.3f}) m, stroke {}:\n           rougher than the cameras resolve here ({:.1f} "
        "mm "
        "over {:.0f} mm): the pen will follow the smoothed surface\n",
        100.0 * limits.rough_share, at.p_W.x(), at.p_W.y(), at.p_W.z(), at.stroke,
        2e3 * at.roughness.misfit, 2e3 * at.roughness.radius);
  }
  if (!suggest) return text;
  const Scenario& s = e.scenario;
  const auto propose = [&](const std::string& setting, const std::string& why) {
    text += fmt::format("  try      --set {}  ({})\n", setting, why);
  };
  const std::size_t before = text.size();
  if (limits.rough_share > 0.1) {
    if (s.perception.noise.sigma_at_1m == 0.0 && s.perception.voxel > 0.0021)
      propose(fmt::format("perception.voxel={:.4g}", s.perception.voxel / 2.0),
              "the surface is rough: smaller patches; nearer cameras or more pixels help more");
    if (s.perception.normals.k > 30)
      propose(fmt::format("perception.normals.k={}", std::max(24, s.perception.normals.k / 2)),
              "a smaller neighbourhood follows finer shape");
    propose(fmt::format("path.draw_speed={:.3g}", std::max(0.015, s.path.draw_speed / 2.0)),
            "a slower pen presses more steadily");
  }
  for (const LimitCost& cost : limits.costs) {
    if (cost.limit.starts_with("path.tilt") && cost.seconds > 0.05 * e.plan.path.duration())
      propose(fmt::format("path.tilt_allowance={:.3g}",
                          std::min(25.0, 2.0 * s.path.tilt_allowance_deg)),
              fmt::format("turning the pen costs {:.1f} s", cost.seconds));
    if (cost.limit == "path.normal_acceleration" && cost.seconds > 0.2 * e.plan.path.duration())
      propose(
          fmt::format("path.normal_acceleration={:.2g}", 2.0 * s.path.normal_acceleration),
          fmt::format("curvature costs {:.1f} s; the force then errs twice as much", cost.seconds));
  }
  if (text.size() == before) text += "  nothing to suggest: the settings suit this surface\n";
  return text;
}

nlohmann::ordered_json plan_limits_json(const PlanLimits& limits) {
  nlohmann::ordered_json json;
  json["slowed"] = nlohmann::ordered_json::array();
  for (const LimitCost& cost : limits.costs)
    json["slowed"].push_back({{"limit", cost.limit},
                              {"seconds", cost.seconds},
                              {"stroke", cost.stroke},
                              {"stroke_seconds", cost.stroke_seconds}});
  json["crawling"] = limits.crawling;
  json["rough_share"] = limits.rough_share;
  const RoughPlace& at = limits.roughest;
  if (at.stroke >= 0)
    json["roughest"] = {{"stroke", at.stroke},
                        {"page_mm", {at.page_mm.x(), at.page_mm.y()}},
                        {"world_m", {at.p_W.x(), at.p_W.y(), at.p_W.z()}},
                        {"misfit_m", at.roughness.misfit},
                        {"patch_radius_m", at.roughness.radius},
                        {"normal_error_rad", at.roughness.slope}};
  return json;
}

namespace {

// The bend, across the surface and beyond that of the spline, of the surface as perception knows it
// best, at places spread evenly along the spline, ends included [1/m].
std::vector<double> finer_bend(const SurfaceEstimator& seen, const Pose& X_WP,
                               const PathSpline& spline) {
  constexpr double kStep = 1e-3;  // [m]
  const int steps = std::max(4, static_cast<int>(std::ceil(spline.length() / kStep)));
  const double du = spline.length() / steps;
  std::vector<double> height(static_cast<std::size_t>(steps) + 1, 0.0);
  for (int i = 0; i <= steps; ++i) {
    const SurfaceEstimate there = seen.estimate(X_WP * spline.at(i * du).p);
    if (there.status == SurfaceStatus::ok) height[static_cast<std::size_t>(i)] = -there.distance;
  }
  // Over two steps either way: finer bends are beyond what the estimate resolves.
  std::vector<double> bend(height.size(), 0.0);
  for (std::size_t i = 2; i + 2 < height.size(); ++i)
    bend[i] = std::abs(height[i + 2] - 2.0 * height[i] + height[i - 2]) / (4.0 * du * du);
  return bend;
}

}  // namespace

SpanLimits stroke_limits(const Belief& belief, const Plan& plan, const PathSettings& settings) {
  const SpanLimits joints =
      JointRates(belief.arm, settings, belief.start_q, plan.rest_q, plan.load);
  if (!belief.perception) return joints;
  return [joints, seen = belief.perception, X_WP = settings.X_WP, fastest = settings.normal_speed,
          acceleration = settings.normal_acceleration](const PathSpline& spline,
                                                       std::vector<SpeedSpan>* spans) {
    const std::vector<double> bend = finer_bend(*seen, X_WP, spline);
    for (std::size_t i = 0; i < spans->size(); ++i) {
      const double at = (spline.start(i) + spline.end(i)) / 2.0;
      const double error = seen->roughness(X_WP * spline.at(at).p).slope;
      double& speed = (*spans)[i].speed;
      if (error > 0.0) speed = std::min(speed, fastest / error);
      const auto k =
          static_cast<std::size_t>(at / spline.length() * static_cast<double>(bend.size() - 1));
      const double sharper = std::max(bend[k], bend[std::min(k + 1, bend.size() - 1)]);
      if (sharper > 0.0) speed = std::min(speed, std::sqrt(acceleration / sharper));
    }
    joints(spline, spans);
  };
}

}  // namespace impedraw

#include "impedraw/experiment/plan_summary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/drawing/polyline.h"
#include "impedraw/experiment/page_of_plan.h"
#include "impedraw/planning/stroke_ruler.h"
#include "impedraw/terminal/progress.h"

namespace impedraw {
namespace {

// Time of the path in each phase, and its length through the air, by one walk along it.
struct PathTally {
  std::array<double, 5> time{};  // of each Phase [s]
  double pen_up = 0.0;           // [m]

  explicit PathTally(const TipPath& path) {
    constexpr double kLook = 0.01;  // [s]
    for (double t = 0.0; t < path.duration(); t += kLook) {
      const PathSample sample = path.at(t);
      time[static_cast<std::size_t>(sample.phase)] += kLook;
      if (sample.phase != Phase::draw) pen_up += sample.reference.v_WD.norm() * kLook;
    }
  }
  double in(Phase phase) const { return time[static_cast<std::size_t>(phase)]; }
};

nlohmann::ordered_json distortion_json(const Distortion& d) {
  return {{"length_min", d.stretch_min}, {"length_max", d.stretch_max},
          {"length_rms", d.stretch_rms}, {"area_min", d.area_min},
          {"area_max", d.area_max},      {"angle_max_deg", d.angle_max * 180.0 / std::numbers::pi}};
}

std::string distortion_text(const char* how, const Distortion& d) {
  const auto percent = [](double ratio) { return 100.0 * (ratio - 1.0); };
  return fmt::format(
      "  {:<10} lengths {:+.1f} to {:+.1f} %, RMS {:.1f} %; areas {:+.1f} to {:+.1f} %; angles up "
      "to {:.1f}°\n",
      how, percent(d.stretch_min), percent(d.stretch_max), 100.0 * d.stretch_rms,
      percent(d.area_min), percent(d.area_max), d.angle_max * 180.0 / std::numbers::pi);
}

Eigen::Vector2d page_size(const PlannedDrawing& e) {
  const Eigen::AlignedBox2d box = bounds_of(e.artwork.shape.drawn.strokes);
  return box.isEmpty() ? Eigen::Vector2d(0.0, 0.0) : Eigen::Vector2d(box.sizes());
}

// The drawing's size, and the reason for it.
std::string size_text(const PlannedDrawing& e) {
  const DrawingSettings& drawing = e.scenario.drawing;
  const Eigen::Vector2d page = page_size(e);
  const double scale = e.artwork.placement.scale();
  const Eigen::Vector2d size = scale * page;
  std::string text = fmt::format("  size     {:.4g} × {:.4g} mm on the canvas", size.x(), size.y());
  const char* whose = !drawing.svg.empty() ? "file" : !drawing.text.text.empty() ? "text" : nullptr;
  if (!whose) return text + "\n";
  if (std::abs(scale - 1.0) < 1e-6) return text + fmt::format(", as in the {}\n", whose);
  text += fmt::format(", {:.3g} × the {}'s {:.4g} × {:.4g} mm", scale, whose, page.x(), page.y());
  if (!has_size(drawing.placement))
    text += fmt::format(
        ": fitted to drawing.placement.fit_radius, {:.3g} m; drawing.placement.scale=1 keeps the "
        "{}'s size",
        drawing.placement.fit_radius_m, whose);
  return text + "\n";
}

}  // namespace

double length_not_drawable(const PlannedDrawing& e) {
  double sum = 0.0;
  for (const Finding& f : e.plan.preflight.findings) sum += f.part.length();
  return sum;
}

double flat_length(const PlacedStroke& stroke, const Placement& placement) {
  return 1e-3 * placement.scale() * length(stroke.page);
}

StrokePart on_artwork(const Plan& plan, const Placement& placement, const StrokePart& part) {
  const auto k = static_cast<std::size_t>(part.stroke);
  StrokePart flat{plan.source[k], part.from, part.to};
  if (!plan.wrap) return flat;
  const PlacedStroke& stroke = (*plan.laid)[k];
  flat.from = stroke.start + flat_length(part_of(stroke, stroke.start, part.from), placement);
  flat.to = flat.from + flat_length(part_of(stroke, part.from, part.to), placement);
  return flat;
}

Distortion projected_distortion(const PlannedDrawing& e) {
  if (e.projected.valid()) return e.projected.get();
  return distortion_of_projection(e.artwork.strokes, e.surface());
}
Distortion wrapped_distortion(const PlannedDrawing& e) {
  return distortion_of_wrap(e.artwork.strokes, e.surface(), e.plan.wrap->chart());
}

nlohmann::ordered_json plan_json(const PlannedDrawing& e) {
  nlohmann::ordered_json json;
  json["strokes"] = e.plan.source.size();
  json["drawable_parts"] = e.plan.strokes.size();
  json["pen_down_m"] = e.plan.path.pen_down_length();
  json["pen_up_m"] = PathTally(e.plan.path).pen_up;
  const Eigen::Vector2d page = page_size(e), size = e.artwork.placement.scale() * page;
  json["page_size_mm"] = {page.x(), page.y()};
  json["size_mm"] = {size.x(), size.y()};
  json["notes"] = notes_of(e);
  json["time_s"] = e.plan.path.duration();
  json["start_q"] = std::vector<double>(e.belief.start_q.begin(), e.belief.start_q.end());
  json["distortion"] = {{"projected", distortion_json(projected_distortion(e))}};
  if (e.plan.wrap) json["distortion"]["wrapped"] = distortion_json(wrapped_distortion(e));
  const PreflightMargins& m = e.plan.preflight.margins;
  // Numbers that are not finite become null.
  json["margins"] = {{"joint_rad", m.joint},
                     {"torque_share", m.torque_share},
                     {"effective_mass_kg", m.effective_mass},
                     {"clearance_m", m.clearance},
                     {"slope_deg", m.slope_deg}};
  json["not_drawable"] = nlohmann::ordered_json::array();
  for (const Finding& f : e.plan.preflight.findings)
    json["not_drawable"].push_back({{"stroke", f.part.stroke},
                                    {"from_mm", 1e3 * f.part.from},
                                    {"to_mm", 1e3 * f.part.to},
                                    {"problem", name_of(f.problem)},
                                    {"text", f.text},
                                    {"page_mm", {f.page_mm.x(), f.page_mm.y()}},
                                    {"world_m", {f.p_W.x(), f.p_W.y(), f.p_W.z()}}});
  if (e.scenario.perception.frames.enabled) {
    json["unreached_at_start"] = nlohmann::ordered_json::array();
    for (const Finding& f : e.plan.where_it_is)
      json["unreached_at_start"].push_back({{"stroke", f.part.stroke}, {"text", finding_text(f)}});
  }
  return json;
}

std::string plan_text(const PlannedDrawing& e) {
  const PathTally tally(e.plan.path);
  const char* const all = e.artwork.notes.empty()
                              ? "all of it can be drawn\n"
                              : "all strokes can be drawn; the notes tell what the artwork loses\n";
  const std::size_t strokes = e.plan.source.size(), parts = e.plan.strokes.size();
  std::string text = fmt::format("{}: {} stroke{}; {} part{} to draw\n", e.scenario.name, strokes,
                                 strokes == 1 ? "" : "s", parts, parts == 1 ? "" : "s");
  text += size_text(e);
  text += fmt::format("  pen down {:.3f} m on the surface, pen up {:.3f} m\n",
                      e.plan.path.pen_down_length(), tally.pen_up);
  text += fmt::format(
      "  time     {} ({:.1f} s): drawing {:.1f} s, approach {:.1f} s, lift {:.1f} s, travel {:.1f} "
      "s\n",
      clock_text(e.plan.path.duration()), e.plan.path.duration(), tally.in(Phase::draw),
      tally.in(Phase::approach), tally.in(Phase::lift), tally.in(Phase::travel));
  if (e.plan.pens) {
    const std::vector<PenSum> sums = sums_of(*e.plan.pens, e.plan.strokes, e.plan.path);
    for (std::size_t k = 0; k < sums.size(); ++k)
      text += "  pen      " + ink_text(e.plan.pens->pens[k], sums[k]) + "\n";
  }
  const PreflightMargins& m = e.plan.preflight.margins;
  if (!e.plan.strokes.empty())
    text += fmt::format(
        "  margins  joints {:.2f} rad, torque {:.0f} % of the limits, tip's greatest effective "
        "mass {:.1f} kg, arm to canvas {}, slope {:.1f}°\n",
        m.joint, 100 * m.torque_share, m.effective_mass,
        std::isfinite(m.clearance) ? fmt::format("{:.0f} mm", 1e3 * m.clearance) : "far",
        m.slope_deg);
  text += distortion_text("projected", projected_distortion(e));
  if (e.plan.wrap) text += distortion_text("wrapped", wrapped_distortion(e));
  for (const std::string& note : notes_of(e)) text += "  note: " + note + "\n";
  if (e.scenario.perception.frames.enabled) {
    text +=
        "  the canvas may move, which is not known before the arm has watched it: a run checks "
        "reach "
        "and joint speeds then, where the canvas will be\n";
    for (const Finding& f : e.plan.where_it_is)
      text += "    where it is now: " + finding_text(f) + "\n";
    if (e.plan.preflight.findings.empty())
      return text + (e.plan.where_it_is.empty() ? std::string("  where it is now, ") + all
                                                : "  its surface allows all of it\n");
  }
  if (e.plan.preflight.findings.empty()) return text + "  " + all;
  text +=
      fmt::format("  cannot be drawn: {} part{}, {:.1f} mm; --skip-unreachable draws the rest\n",
                  e.plan.preflight.findings.size(),
                  e.plan.preflight.findings.size() == 1 ? "" : "s", 1e3 * length_not_drawable(e));
  for (const Finding& f : e.plan.preflight.findings) text += "    " + finding_text(f) + "\n";
  return text;
}

std::string refusal_text(const Finding& f, bool seen) {
  static constexpr const char* kWords[] = {"leaves the canvas",
                                           "crosses a fold of the surface",
                                           "crosses a crease of the surface",
                                           "crosses what is too rough",
                                           "lies on too steep a slope",
                                           "leaves the arm's reach",
                                           "brings a joint to its limit",
                                           "brings the arm near a singular posture",
                                           "needs too much torque",
                                           "makes the arm touch the canvas or the table",
                                           "makes the pen's shaft touch the canvas or the table",
                                           "cannot be followed without a jump of the joints",
                                           "would have to crawl",
                                           "leaves too short a remainder"};
  static_assert(std::size(kWords) == static_cast<std::size_t>(Problem::too_short) + 1);
  return fmt::format(
      "stroke {} {}{}: {}, farthest at page ({:.1f}, {:.1f}) mm, world ({:.4f}, {:.4f}, {:.4f}) m",
      f.part.stroke, kWords[static_cast<std::size_t>(f.problem)],
      seen && f.problem == Problem::off_canvas ? ", as the cameras see it" : "", f.text,
      f.page_mm.x(), f.page_mm.y(), f.p_W.x(), f.p_W.y(), f.p_W.z());
}

std::string finding_text(const Finding& f) {
  return fmt::format(
      "stroke {}, {:.1f} to {:.1f} mm of it: {}: {}; worst at page ({:.1f}, {:.1f}) mm, world "
      "({:.3f}, {:.3f}, {:.3f}) m",
      f.part.stroke, 1e3 * f.part.from, 1e3 * f.part.to, name_of(f.problem), f.text, f.page_mm.x(),
      f.page_mm.y(), f.p_W.x(), f.p_W.y(), f.p_W.z());
}

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
constexpr const char* kTurning = "the turning of the pen's axis";
constexpr Lifted kLimits[] = {
    {"path.normal_acceleration", [](PathSettings& s) { s.normal_acceleration = 100.0; }},
    {"the speed across roughness", [](PathSettings& s) { s.normal_speed = 1.0; }},
    {kTurning, [](PathSettings& s) { s.tilt_speed = 20.0, s.tilt_acceleration = kFree; }},
    {"the joints' speeds, accelerations and torques",
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
    if (cost.limit == kTurning && cost.seconds > 0.05 * e.plan.path.duration())
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

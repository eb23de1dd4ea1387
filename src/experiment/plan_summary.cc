#include "impedraw/experiment/plan_summary.h"

#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/experiment/preview_of.h"
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

Distortion projected_distortion(const PlannedDrawing& e) {
  if (e.projected.valid()) return e.projected.get();
  return distortion_of_projection(e.artwork.strokes, e.surface());
}
Distortion wrapped_distortion(const PlannedDrawing& e) {
  return distortion_of_wrap(e.artwork.strokes, e.surface(), e.plan.wrap->chart());
}

nlohmann::ordered_json plan_json(const PlannedDrawing& e) {
  nlohmann::ordered_json json;
  json["strokes"] = e.plan.requested.size();
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
  const auto number = [](double x) {
    return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json(nullptr);
  };
  json["margins"] = {{"joint_rad", number(m.joint)},
                     {"torque_share", number(m.torque_share)},
                     {"effective_mass_kg", number(m.effective_mass)},
                     {"clearance_m", number(m.clearance)},
                     {"slope_deg", number(m.slope_deg)}};
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
  const std::size_t strokes = e.plan.requested.size(), parts = e.plan.strokes.size();
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

}  // namespace impedraw

#include "impedraw/experiment/plan_summary.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/app/commands.h"
#include "impedraw/experiment/plan_limits.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/planning/stroke_ruler.h"
#include "impedraw/planning/wrap/distortion.h"
#include "impedraw/report/distortion_picture.h"
#include "impedraw/report/plan_picture.h"
#include "impedraw/run/draw_into.h"
#include "impedraw/run/run_folder.h"
#include "impedraw/terminal/progress.h"
#include "impedraw/terminal/say.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;

constexpr double kSpacing = 2e-3;  // of points in the picture [m]

// "off canvas", for a legend.
std::string words_of(Problem problem) {
  std::string words = name_of(problem);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

// Each part of a stroke where it lies on the surface, in P.
PlanLine plan_line(const StrokeRuler& part, const SurfaceHeight& surface, double z,
                   const std::string& problem) {
  PlanLine line{{}, problem};
  const double length = part.length();
  const int pieces = std::max(1, static_cast<int>(std::ceil(length / kSpacing)));
  for (int i = 0; i <= pieces; ++i) {
    const Eigen::Vector2d p = part.at(part.stroke().start + length * i / pieces).p_P;
    const auto sample = surface(p.x(), p.y());
    line.points.push_back(sample ? sample->p_P : Eigen::Vector3d(p.x(), p.y(), z));
  }
  return line;
}

void write_picture(const PlannedDrawing& e, const SurfaceHeight& surface, const fs::path& stem) {
  PlanPicture picture;
  picture.title = e.scenario.name;
  picture.subtitle = fmt::format(
      "{} strokes, {:.2f} m; {}", e.plan.requested.size(), e.plan.path.pen_down_length(),
      e.plan.preflight.findings.empty()
          ? "all can be drawn"
          : fmt::format("{:.0f} mm cannot be drawn", 1e3 * length_not_drawable(e)));
  const Pose X_PW = e.artwork.X_WP.inverse();
  for (const Eigen::Vector3d& v_W : e.scene.canvas->mesh().vertices)
    picture.canvas_vertices.push_back(X_PW * v_W);
  picture.canvas_triangles = e.scene.canvas->mesh().triangles;
  for (const PlacedStroke& stroke : e.plan.strokes)
    picture.lines.push_back(plan_line(StrokeRuler(stroke), surface, 0.0, ""));
  std::optional<StrokeRuler> ruler;
  for (const Finding& f : e.plan.preflight.findings) {
    const PlacedStroke& whole = e.artwork.strokes[static_cast<std::size_t>(f.part.stroke)];
    if (!ruler || &ruler->stroke() != &whole) ruler.emplace(whole);
    const PlacedStroke part = ruler->part(f.part.from, f.part.to);
    picture.lines.push_back(
        plan_line(StrokeRuler(part), surface, (X_PW * f.p_W).z(), words_of(f.problem)));
  }
  // The map of roughness: a dot for each point of the cloud.
  if (e.scene.perception)
    for (const Eigen::Vector3d& p_W : e.scene.perception->cloud().points)
      if (is_unresolved(e.scene.perception->roughness(p_W)))
        picture.lines.push_back({{X_PW * p_W}, "rougher than the cameras resolve"});
  write_plan(picture, stem);
}

}  // namespace

int plan(const DrawOptions& options, bool as_json, bool suggest) {
  Places places;
  Scenario scenario = resolve(options, &places);
  const fs::path folder =
      options.out.empty() ? fs::path("runs") / (scenario.name + "-plan") : options.out;
  require_plan_folder(folder);
  scenario = placed(options, scenario, places);
  PlannedDrawing e = prepare_plan_visibly(scenario, places);
  make_folder(folder);
  const PlanLimits limits = plan_limits(e);
  nlohmann::ordered_json whole = plan_json(e);
  whole["limits"] = plan_limits_json(limits);
  const std::string json = whole.dump(2) + "\n";
  write_whole(folder / "plan.json", json);
  {
    ProgressLine line;
    double length = 0.0;
    for (const PlacedStroke& stroke : e.artwork.strokes) length += plane_length(stroke);
    const double looks = length / kSpacing + 2.0 * static_cast<double>(e.artwork.strokes.size());
    write_picture(
        e,
        [&line, looks, surface = e.surface(), n = 0L](double x, double y) mutable {
          if (++n % 256 == 0)
            line.update("drawing the picture", std::min(1.0, static_cast<double>(n) / looks));
          return surface(x, y);
        },
        folder / "plan");
  }
  say(stdout, "{}", as_json ? json : plan_text(e) + plan_limits_text(e, limits, suggest));
  if (e.plan.wrap) {
    write_distortion({e.scenario.name, e.plan.wrap->chart(), e.artwork.strokes, e.plan.requested,
                      projected_distortion(e), wrapped_distortion(e)},
                     folder / "distortion");
  }
  if (!as_json)
    say(stdout, "picture  {}\n", fs::absolute(folder / "plan.png").lexically_normal().string());
  return e.plan.preflight.findings.empty() ? kFinished : kMissed;
}

}  // namespace impedraw

#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/app/commands.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/line_forces.h"
#include "impedraw/experiment/page_context.h"
#include "impedraw/experiment/page_of_plan.h"
#include "impedraw/experiment/plan_summary.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/wrap/distortion.h"
#include "impedraw/report/distortion_picture.h"
#include "impedraw/report/plan_picture.h"
#include "impedraw/report/report.h"
#include "impedraw/run/run_folder.h"
#include "impedraw/run/simulated_arm.h"
#include "impedraw/settings/yaml_write.h"
#include "impedraw/terminal/progress.h"
#include "impedraw/terminal/say.h"

namespace impedraw {

namespace fs = std::filesystem;

int plan(const DrawOptions& options, bool as_json, bool suggest) {
  Places places;
  Scenario scenario = resolve(options, &places);
  const fs::path folder =
      options.out.empty() ? fs::path("runs") / (scenario.name + "-plan") : options.out;
  require_plan_folder(folder);
  scenario = placed(options, scenario, places);
  const PreparedPlan e = prepare_plan_visibly(scenario, places);
  make_folder(folder);
  const PlanLimits limits = plan_limits(e);
  nlohmann::ordered_json whole = plan_json(e);
  whole["limits"] = plan_limits_json(limits);
  const std::string json = whole.dump(2) + "\n";
  write_whole(folder / "plan.json", json);
  PlanPage page;
  {
    ProgressLine line;
    double length = 0.0;
    for (const PlacedStroke& stroke : e.artwork.strokes) length += plane_length(stroke);
    const double looks =
        length / kPictureSpacing + 2.0 * static_cast<double>(e.artwork.strokes.size());
    const SurfaceHeight told = counted(
        e.surface(), looks, [&line](double share) { line.update("drawing the picture", share); });
    const PlanPicture picture = picture_of_plan(e, told);
    write_plan(picture, folder / "plan");
    const DrawnPens pens = e.plan.pens.value_or(DrawnPens{{DrawnPen{e.scenario.pen}}});
    write_preview(preview_of(e.scenario, SettingErrors(places), e.artwork, pens.pens,
                             sums_of(pens, e.plan.strokes, e.plan.path)),
                  folder / "pens");
    page = page_of_plan(e, picture,
                        [&line](double share) { line.update("following the path", share); });
  }
  say(stdout, "{}", as_json ? json : plan_text(e) + plan_limits_text(e, limits, suggest));
  if (e.plan.wrap) {
    write_distortion({e.scenario.name, e.plan.wrap->chart(), e.artwork.strokes, *e.plan.laid,
                      projected_distortion(e), wrapped_distortion(e)},
                     folder / "distortion");
  }
  page.scenario = settings_yaml(e.scenario);
  page.numbers = json;
  page.pictures = {{"The plan, seen from above", shown_picture(folder / "plan")},
                   {"Pens, order, and what is hidden", shown_picture(folder / "pens")},
                   {"Distortion of lengths", shown_picture(folder / "distortion")}};
  const PageContext context = page_context(e.scenario, e.artwork, "");
  write_whole(folder / "plan.html", page_html(page.title, {make_payload(page, context)}));
  if (!as_json)
    for (const auto& [name, file] :
         {std::pair{"picture", "plan.png"}, {"flat", "pens.png"}, {"page", "plan.html"}})
      say(stdout, "{:<8} {}\n", name, fs::absolute(folder / file).lexically_normal().string());
  return e.plan.preflight.findings.empty() ? kFinished : kMissed;
}

int preview(const DrawOptions& options) {
  Places places;
  const Scenario scenario = resolve(options, &places);
  const SettingErrors setting_errors(places);
  PlacedArtwork artwork = load_artwork(scenario.drawing, setting_errors);
  give_forces(scenario, setting_errors, &artwork);
  const Artwork& drawn = artwork.shape.drawn;
  DrawnPens pens{layer_pens(scenario, drawn, setting_errors)};
  for (const Stroke& stroke : drawn.strokes) pens.of_stroke.push_back(stroke.layer);
  PathSettings flat = scenario.path;
  const Eigen::Vector2d& centre = scenario.drawing.placement.centre_m;
  flat.start_p_WE = {centre.x(), centre.y(), 0.1};
  const std::vector<PenSum> sums =
      sums_of(pens, artwork.strokes, plan_tip_path(artwork.strokes, level_surface(0.0), flat));
  PreviewPicture picture = preview_of(scenario, setting_errors, artwork, pens.pens, sums);
  const double time = std::accumulate(sums.begin(), sums.end(), 0.0,
                                      [](double t, const PenSum& sum) { return t + sum.time; });
  picture.subtitle += fmt::format(", about {:.0f} s on a plane", time);
  std::string text = fmt::format("{}: {} stroke{}, {}\n", drawn.name, drawn.strokes.size(),
                                 drawn.strokes.size() == 1 ? "" : "s", picture.subtitle);
  for (std::size_t k = 0; k < sums.size(); ++k)
    text += "  pen          " + ink_text(pens.pens[k], sums[k]) + "\n";
  if (drawn.hidden_mm > 0.0)
    text += fmt::format("  hidden       {:.1f} mm on the page\n", drawn.hidden_mm);
  if (drawn.doubled_mm > 0.0)
    text += fmt::format("  doubled      {:.1f} mm on the page\n", drawn.doubled_mm);
  for (const std::string& note : artwork.notes) text += "  note         " + note + "\n";
  fs::path stem = options.out.empty() ? fs::path(scenario.name + "-preview") : options.out;
  if (stem.extension() == ".png" || stem.extension() == ".svg") stem.replace_extension();
  if (stem.has_parent_path()) fs::create_directories(stem.parent_path());
  write_preview(picture, stem);
  say(stdout, "{}picture  {}.png\n", text, fs::absolute(stem).lexically_normal().string());
  return kFinished;
}

}  // namespace impedraw

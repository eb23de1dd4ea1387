#include <numeric>

#include <fmt/format.h>

#include "impedraw/app/commands.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/line_forces.h"
#include "impedraw/experiment/preview_of.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/terminal/say.h"

namespace impedraw {

namespace fs = std::filesystem;

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

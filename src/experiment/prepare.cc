#include "impedraw/experiment/prepare.h"

#include <utility>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/line_forces.h"

namespace impedraw {

namespace {

// It has copies of what it reads, or keeps it: artwork and belief move on meanwhile.
std::shared_future<Distortion> distortion_beside(const PlacedArtwork& artwork,
                                                 const Belief& belief) {
  return std::async(std::launch::async,
                    [strokes = artwork.strokes, surface = belief.surface] {
                      return distortion_of_projection(strokes, surface);
                    })
      .share();
}

}  // namespace

PreparedPlan prepare_plan(const Scenario& given, const Places& places, Unreachable unreachable,
                          const PrepareProgress& progress, SceneCache* scenes,
                          PlanSummary summary) {
  const SettingErrors setting_errors(places);
  Scenario scenario = given;
  scenario.drawing.placement = placement_settings(scenario.drawing);
  if (progress) progress("reading and ordering the artwork", 0.0);
  PlacedArtwork artwork = load_artwork(scenario.drawing, setting_errors, [&](double share) {
    if (progress) progress("ordering the strokes", 0.05 + 0.15 * share);
  });
  give_forces(scenario, setting_errors, &artwork);
  if (progress) progress("looking at the canvas", 0.2);
  Scene scene = scenes ? scenes->take(scenario, artwork.X_WP, setting_errors)
                       : build_scene(scenario, artwork.X_WP, setting_errors);
  try {
    std::shared_future<Distortion> projected;
    if (summary == PlanSummary::beside) projected = distortion_beside(artwork, scene.belief);
    Plan plan = make_plan(scenario, artwork, scene.belief, unreachable, setting_errors, progress);
    return {{std::move(scenario), std::move(artwork), std::move(scene.belief), std::move(plan),
             std::move(projected)},
            std::move(scene.truth)};
  } catch (...) {
    if (scenes) scenes->give_back(std::move(scene));
    throw;
  }
}

Prepared prepare(const Scenario& scenario, const Places& places, Unreachable unreachable,
                 const PrepareProgress& progress, SceneCache* scenes, PlanSummary summary) {
  std::vector<KeptInput> inputs = read_input_files(scenario);  // before their content is used
  PreparedPlan plan = prepare_plan(scenario, places, unreachable, progress, scenes, summary);
  try {
    ControlSetup control = control_for(&plan, places);
    Yardstick yardstick = yardstick_of(plan, plan.truth, progress);
    return {{std::move(plan), std::move(inputs), std::move(control), std::move(yardstick)},
            std::move(plan.truth)};
  } catch (...) {
    if (scenes) scenes->give_back(scene_of(std::move(plan)));
    throw;
  }
}

}  // namespace impedraw

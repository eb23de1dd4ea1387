#include "impedraw/experiment/experiment.h"

#include <utility>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/line_forces.h"
#include "impedraw/experiment/pen_axis.h"
#include "impedraw/experiment/rotor_check.h"
#include "impedraw/experiment/spring_check.h"

namespace impedraw {

namespace {

bool is_given(const Places& places, const std::string& setting) {
  return !places.of(setting).starts_with("default of ");
}

// It has copies of what it reads, or keeps it: artwork and scene move on meanwhile.
std::shared_future<Distortion> distortion_beside(const PlacedArtwork& artwork, const Scene& scene) {
  return std::async(std::launch::async,
                    [strokes = artwork.strokes, surface = scene.surface] {
                      return distortion_of_projection(strokes, surface);
                    })
      .share();
}

}  // namespace

PlannedDrawing prepare_plan(const Scenario& given, const Places& places, Unreachable unreachable,
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
    if (summary == PlanSummary::beside) projected = distortion_beside(artwork, scene);
    Plan plan = make_plan(scenario, artwork, scene, unreachable, setting_errors, progress);
    return {std::move(scenario), std::move(artwork), std::move(scene), std::move(plan),
            std::move(projected)};
  } catch (...) {
    if (scenes) scenes->give_back(std::move(scene));
    throw;
  }
}

ControlSetup control_for(PlannedDrawing* drawing, const Places& places) {
  const bool rough = drawing->plan.rough;
  ImpedanceSettings& s = drawing->scenario.control;
  if (!is_given(places, "control.pen_axis"))
    s.surface.pen_axis = rough ? PenAxis::plan : PenAxis::surface;
  if (!is_given(places, "control.normal_error"))
    s.friction.normal_error_deg = rough ? kRoughNormalError : 0.0;
  if (!is_given(places, "control.felt_normal.share"))
    s.felt_normal.share = rough ? kRoughFeltShare : 0.0;
  const SettingErrors setting_errors(places);
  ControlSetup control =
      make_control_setup(drawing->scenario, drawing->scene, drawing->plan, setting_errors);
  bear_joint_springs(drawing->scenario, drawing->scene.arm, drawing->scene.start_q,
                     drawing->plan.rest_q, &control, &drawing->plan.notes, setting_errors);
  check_rotors(drawing->scenario, control, drawing->scene.arm, drawing->plan.rest_q,
               &drawing->plan.notes, setting_errors);
  return control;
}

Experiment prepare(const Scenario& scenario, const Places& places, Unreachable unreachable,
                   const PrepareProgress& progress, SceneCache* scenes, PlanSummary summary) {
  std::vector<KeptInput> inputs = read_input_files(scenario);  // before their content is used
  PlannedDrawing drawing = prepare_plan(scenario, places, unreachable, progress, scenes, summary);
  try {
    ControlSetup control = control_for(&drawing, places);
    return {std::move(drawing), std::move(inputs), std::move(control)};
  } catch (...) {
    if (scenes) scenes->give_back(std::move(drawing.scene));
    throw;
  }
}

std::vector<std::string> notes_of(const PlannedDrawing& drawing) {
  std::vector<std::string> notes = drawing.artwork.notes;
  notes.insert(notes.end(), drawing.scene.notes.begin(), drawing.scene.notes.end());
  notes.insert(notes.end(), drawing.plan.notes.begin(), drawing.plan.notes.end());
  return notes;
}

}  // namespace impedraw

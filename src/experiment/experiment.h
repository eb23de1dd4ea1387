// A scenario made ready to run, in stages:
//
//   Scenario ─ load_artwork ─> PlacedArtwork ─┐
//            ─ build_scene ──> Scene ─────────┼─ make_plan ─> Plan ─ make_control_setup ─>
//            ControlSetup ─ run (run/run.h) ─> RunOutcome
//
// Each stage is a plain struct, made by one function from earlier stages (artwork.h, scene.h,
// plan.h, control_setup.h). All errors in a scenario are found here, before any file is written.
#pragma once

#include <future>
#include <string>
#include <vector>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/control_setup.h"
#include "impedraw/experiment/input_files.h"
#include "impedraw/experiment/plan.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/experiment/scene.h"
#include "impedraw/experiment/scene_cache.h"
#include "impedraw/planning/wrap/distortion.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

// The stages that determine what will be drawn.
struct PlannedDrawing {
  Scenario scenario;  // as given, with the placement completed
  PlacedArtwork artwork;
  Scene scene;
  Plan plan;
  // Distortion of the drawing's lengths when it is projected, if it was asked for: see
  // prepare_plan().
  std::shared_future<Distortion> projected{};

  const SurfaceHeight& surface() const { return scene.surface; }  // the planner's, in P
};

struct Experiment : PlannedDrawing {
  std::vector<KeptInput> inputs;
  ControlSetup control;
};

// Throws InputError: one line that names the error, its location and what is valid. `places` holds
// the source location of each setting, in the YAML or on the command line. Deterministic. `scenes`:
// where the scene is taken from, and given back to where this throws; the caller gives it back
// after the drawing. `summary`: of the plan, will be asked for; what of it takes long is computed
// on a thread of its own, beside the planning.
enum class PlanSummary { later, beside };
PlannedDrawing prepare_plan(const Scenario& scenario, const Places& places = {},
                            Unreachable unreachable = Unreachable::refuse,
                            const PrepareProgress& progress = {}, SceneCache* scenes = nullptr,
                            PlanSummary summary = PlanSummary::later);
Experiment prepare(const Scenario& scenario, const Places& places = {},
                   Unreachable unreachable = Unreachable::refuse,
                   const PrepareProgress& progress = {}, SceneCache* scenes = nullptr,
                   PlanSummary summary = PlanSummary::later);

// The last stage: completes the controller's settings in the drawing's scenario, and adds notes to
// its plan. Throws InputError, too, for rotors that the law would not bear (rotor_check.h).
ControlSetup control_for(PlannedDrawing* drawing, const Places& places);

// Repairs to the input, and what is not drawn, one line each.
std::vector<std::string> notes_of(const PlannedDrawing& drawing);

}  // namespace impedraw

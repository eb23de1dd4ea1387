// A scenario made ready to run, in stages:
//
//   Scenario ─ load_artwork ─> PlacedArtwork ─┐
//            ─ build_scene ──> Scene ─────────┼─ make_plan ─> Plan ─ make_control_setup ─>
//            ControlSetup ─ run (run/run.h) ─> RunOutcome
//
// Each is a plain struct, made by one function from those before it (artwork.h, scene.h, plan.h,
// control_setup.h). Everything that can be wrong with a scenario is found here, before any file is
// written.
#pragma once

#include <string>
#include <vector>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/control_setup.h"
#include "impedraw/experiment/plan.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/experiment/scene.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

// As far as it can be told what will be drawn.
struct PlannedDrawing {
  Scenario scenario;  // as given, its placement completed
  PlacedArtwork artwork;
  Scene scene;
  Plan plan;

  // The surface that the planner goes by, in P. Refers to the scene.
  SurfaceHeight surface() const { return scene.surface(artwork.X_WP); }
};

struct Experiment : PlannedDrawing {
  ControlSetup control;
};

// Throws InputError: one line that names what, where, and what would be valid; `places` say where
// in the YAML or on the command line the settings were given. The same scenario gives the same
// experiment.
PlannedDrawing prepare_plan(const Scenario& scenario, const Places& places = {},
                            Unreachable unreachable = Unreachable::refuse,
                            const PrepareProgress& progress = {});
Experiment prepare(const Scenario& scenario, const Places& places = {},
                   Unreachable unreachable = Unreachable::refuse,
                   const PrepareProgress& progress = {});

// What was repaired on the way in, and what is not drawn; a line each.
std::vector<std::string> notes_of(const PlannedDrawing& drawing);

}  // namespace impedraw

// All stages of an experiment (experiment.h), and the truth beside them. All errors in a scenario
// are found here, before any file is written.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "impedraw/experiment/experiment.h"
#include "impedraw/experiment/place_surface.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/experiment/scene.h"
#include "impedraw/experiment/truth.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

// The command-line options of a drawing, and the scenario they resolve to.
struct DrawOptions {
  std::filesystem::path scenario;
  // This program's own scenario, where none is named; no message cites it. Empty: the standard
  // bowl, with the sine (bowl-sine.yaml) or with svg or text (artwork.yaml).
  std::filesystem::path built_in;
  std::string shape;
  std::filesystem::path svg;
  std::string text;  // to draw
  bool no_perception = false;
  std::string layer;              // that are drawn, by number or name; empty: all
  bool keep_order = false;        // of a file's strokes
  bool skip_unreachable = false;  // omits what fails the pre-flight
  // fixed; auto: of the canvas; surface: of the drawing on it; empty: auto where an arm of one's
  // own cannot draw on the canvas and the scenario does not place it.
  std::string place;
  SurfaceWish surface;                   // for place surface
  bool resume = false;                   // continues the run in `out`
  bool overwrite = false;                // replaces a finished run in `out`
  std::string arm;                       // sim, iiwa-lcm, franka; empty: as the scenario says
  std::filesystem::path out;             // empty: runs/<name> in the working directory
  std::vector<std::string> assignments;  // --set
};

// The scenario with all command-line options applied. `places` gets the source location of each
// setting. Throws InputError.
Scenario resolve(const DrawOptions& options, Places* places = nullptr);

struct PreparedPlan : PlannedDrawing {
  Truth truth;
};

struct Prepared : Experiment {
  Truth truth;
};

// Time of the work for a summary of the plan: once it is asked for, or beside the planning, on a
// thread of its own.
enum class PlanSummary { later, beside };

// Throws InputError: one line that names the error, its location and what is valid. `places` holds
// the source location of each setting, in the YAML or on the command line. Deterministic. `scenes`:
// where the scene is taken from, and given back to where this throws; the caller gives it back
// after the drawing.
PreparedPlan prepare_plan(const Scenario& scenario, const Places& places = {},
                          Unreachable unreachable = Unreachable::refuse,
                          const PrepareProgress& progress = {}, SceneCache* scenes = nullptr,
                          PlanSummary summary = PlanSummary::later);
Prepared prepare(const Scenario& scenario, const Places& places = {},
                 Unreachable unreachable = Unreachable::refuse,
                 const PrepareProgress& progress = {}, SceneCache* scenes = nullptr,
                 PlanSummary summary = PlanSummary::later);

// The scene of a drawing that has ended, for SceneCache::give_back().
template <class Drawing>
Scene scene_of(Drawing&& drawing) {
  return {std::move(drawing.belief), std::move(drawing.truth)};
}

}  // namespace impedraw

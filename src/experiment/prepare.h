// All stages of an experiment (experiment.h), and the truth beside them. All errors in a scenario
// are found here, before any file is written.
#pragma once

#include "impedraw/experiment/experiment.h"
#include "impedraw/experiment/scene.h"
#include "impedraw/experiment/truth.h"

namespace impedraw {

struct PreparedPlan : PlannedDrawing {
  Truth truth;
};

struct Prepared : Experiment {
  Truth truth;
};

// Whether a summary of the plan will be asked for: what takes long of it is then computed on a
// thread of its own, beside the planning.
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

// A scenario made ready to run, in stages (prepare.h):
//
//   Scenario ─ load_artwork ─> PlacedArtwork ─────────────────┐
//            ─ build_scene ─┬> Belief ────────────────────────┼─ make_plan ─> Plan
//                           │  Belief, Plan ─ make_control_setup ─> ControlSetup
//                           └> Truth ─ yardstick_of ─> Yardstick
//
// Each stage is a plain struct, made by one function from earlier stages (artwork.h, scene.h,
// plan.h, control_setup.h, truth.h). Nothing that drives an arm sees the truth.
#pragma once

#include <future>
#include <memory>
#include <string>
#include <vector>

#include "impedraw/canvas/triangle_mesh.h"
#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/belief.h"
#include "impedraw/experiment/control_setup.h"
#include "impedraw/experiment/input_files.h"
#include "impedraw/experiment/plan.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/metrics/ending.h"
#include "impedraw/planning/target.h"
#include "impedraw/planning/wrap/distortion.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

class Canvas;

// The data that a drawing is judged against, for log and metrics. The loop does not read it.
struct Yardstick {
  TargetLine target;                      // the promised strokes on the true canvas, in W
  TriangleMesh canvas;                    // the true one, as the run begins, in W
  std::shared_ptr<const Canvas> surface;  // the same, to be searched
  bool canvas_moves = false;
  Promise promise;
};

// The stages that determine what will be drawn.
struct PlannedDrawing {
  Scenario scenario;  // as given, with the placement completed
  PlacedArtwork artwork;
  Belief belief;
  Plan plan;
  // Distortion of the drawing's lengths when it is projected, if it was asked for: see
  // prepare_plan().
  std::shared_future<Distortion> projected{};

  const SurfaceHeight& surface() const { return belief.surface; }  // the planner's, in P
};

struct Experiment : PlannedDrawing {
  std::vector<KeptInput> inputs;
  ControlSetup control;
  Yardstick yardstick;
};

// The stage after the plan: completes the controller's settings in the drawing's scenario, and adds
// notes to its plan. Throws InputError, too, for rotors that the law would not bear.
ControlSetup control_for(PlannedDrawing* drawing, const Places& places);

// Repairs to the input, and what is not drawn, one line each.
std::vector<std::string> notes_of(const PlannedDrawing& drawing);

}  // namespace impedraw

// The truth of an experiment: for the simulated arm, and for what a drawing is judged against.
// Plan, control set-up and loop see a Belief (belief.h).
#pragma once

#include <memory>

#include "impedraw/experiment/experiment.h"
#include "impedraw/simulation/world.h"

namespace impedraw {

struct Truth {
  std::shared_ptr<Canvas> canvas;
  std::unique_ptr<World> world;  // at the start posture; refers to the canvas
};

// The promised strokes on the true canvas, of its sheets the one nearest to the plan. Where there
// is none, as planned.
TargetLine target_of(const PlannedDrawing& drawing, const Truth& truth,
                     const PrepareProgress& progress = {});

Yardstick yardstick_of(const PlannedDrawing& drawing, const Truth& truth,
                       const PrepareProgress& progress = {});

// The pre-flight's promise for a drawing, in numbers.

// target: the promised strokes on the true canvas, in W (target_of).
Promise promise_of(const PlannedDrawing& drawing, const Truth& truth, const TargetLine& target);

// The artwork's length that is neither promised nor named [m].
double unnamed_length(const PlannedDrawing& drawing);

// The artwork's length that a planner could draw if it knew the true canvas [m], see Promise.
double reachable_length(const PlannedDrawing& drawing, const Truth& truth);

}  // namespace impedraw

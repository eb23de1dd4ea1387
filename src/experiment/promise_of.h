// The pre-flight's promise for a drawing, in numbers.
#pragma once

#include "impedraw/experiment/truth.h"

namespace impedraw {

// target: the promised strokes on the true canvas, in W (target_of).
Promise promise_of(const PlannedDrawing& drawing, const Truth& truth, const TargetLine& target);

// The artwork's length that is neither promised nor named [m].
double unnamed_length(const PlannedDrawing& drawing);

// The artwork's length that a planner could draw if it knew the true canvas [m], see Promise.
double reachable_length(const PlannedDrawing& drawing, const Truth& truth);

}  // namespace impedraw

// Sources of the control loop: the perceived surface, and the motion of the canvas.
#pragma once

#include <memory>

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/canvas_watch.h"
#include "impedraw/run/control_loop.h"
#include "impedraw/run/disturbances.h"

namespace impedraw {

// True if the plan follows a canvas that may move.
bool follows_canvas(const Experiment& experiment, const Driver& driver);

// The scenario's disturbances: they occur in the first run only, not in a resumed one.
Disturbances disturbances_of(const Experiment& experiment, bool resumed);

// The cameras that keep capturing; null where none does. X_WK: of the canvas, when the run begins.
std::unique_ptr<CanvasWatch> canvas_watch(const Experiment& experiment, Driver& driver,
                                          const Pose& X_WK);

// The perceived surface, without that which the scenario's faults hide; empty without perception.
// growing: null where the surface stays as the snapshot saw it.
SurfaceSource surface_source(const Experiment& experiment, Disturbances disturbances,
                             const GrowingSurface* growing);

// The canvas by the cameras or, where there is no watch, by its true motion; empty where it stands.
CanvasSource canvas_source(const Experiment& experiment, CanvasWatch* watch, const Driver& driver);

}  // namespace impedraw

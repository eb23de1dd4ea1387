// The one look that the depth cameras take at canvas and arm, before anything is drawn.
#pragma once

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/simulation/world.h"

namespace impedraw {

// The arm is seen at q, and its own points are taken out of the cloud. InputError: no cameras, or
// too little of the canvas in view.
SurfaceEstimator take_snapshot(const Scenario& scenario, const Canvas& canvas, const World& world,
                               ArmModel& arm, const JointVector& q);

}  // namespace impedraw

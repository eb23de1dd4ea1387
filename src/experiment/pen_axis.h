// The pen's axis while drawing, where the scenario leaves it open.
#pragma once

#include "impedraw/control/impedance_settings.h"
#include "impedraw/experiment/plan.h"
#include "impedraw/experiment/scene.h"

namespace impedraw {

// On a smooth surface the estimated normal is the better axis, also where a hand pushes the pen off
// its line. Where the surface under the drawing is rough, the plan's smoothed normals are: along
// over a tenth of it, perception's normal is 0.02 rad off them.
PenAxis suitable_pen_axis(const Scene& scene, const Plan& plan);

}  // namespace impedraw

// The choice of the pen's axis by the surface's roughness, where the scenario leaves it open.
#pragma once

#include "impedraw/experiment/belief.h"
#include "impedraw/experiment/plan.h"

namespace impedraw {

// Finer patches than the plan's are in use under the drawing: along over a tenth of it,
// perception's normal is 0.02 rad off the plan's.
//
// On a smooth surface the estimated normal is the better axis of the pen, also where a hand pushes
// it off its line, and whatever pushes it aside is a hand. On a rough one the plan's smoothed
// normals are the better axis, and the surface itself pushes the tip aside.
bool is_rough(const Belief& belief, const Plan& plan);

inline constexpr double kRoughNormalError = 30.0;  // [deg]
inline constexpr double kRoughFeltShare = 0.5;     // FeltNormalSettings

}  // namespace impedraw

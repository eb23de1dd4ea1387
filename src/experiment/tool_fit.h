// The fit of a tool's face to the lines and the surface.
#pragma once

#include "impedraw/experiment/plan.h"

namespace impedraw {

// Throws InputError where the face does not fit the lines or the surface: an edge whose ends leave
// a corner or a bend by more than 0.2 mm, or, on a curved surface, do not touch; a pad of whose rim
// nothing touches.
void require_fit(const Scenario& scenario, const Plan& plan, const SurfaceHeight& surface,
                 const SettingErrors& setting_errors);

// Throws InputError where the force presses a pad's foam nearly flat.
void require_foam(const Scenario& scenario, const SettingErrors& setting_errors);

}  // namespace impedraw

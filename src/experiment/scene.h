// Stage 2 of an experiment, Scenario → Scene: the true canvas in the simulated world, and what the
// controller's arm model and the depth cameras' view of the canvas make of both.
#pragma once

#include "impedraw/experiment/belief.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/experiment/truth.h"
#include "impedraw/settings/setting_error.h"

namespace impedraw {

struct Scene {
  Belief belief;
  Truth truth;
};

// A mesh file that lies nowhere near the drawing, and that the scenario does not place, is put
// under the drawing's centre; scenario.canvas.move is set to what that takes, and a note says so.
// Only the mesh's bounding box is used for it.
//
// The arm starts with the pen normal to the drawing plane of X_WP. `placed`: false where the
// drawing's place on the object is yet to be found (capture/found_canvas.h). Throws InputError for
// an invalid canvas or arm, a start out of reach, or too little of the canvas in view.
Scene build_scene(Scenario& scenario, const Pose& X_WP, const SettingErrors& setting_errors,
                  bool placed = true);

// Checks settings that do not make the scene but name its joints and links. Throws InputError.
void check_scene(const Scenario& scenario, const Scene& scene, const SettingErrors& setting_errors);

}  // namespace impedraw

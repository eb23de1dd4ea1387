// Stage 2 of an experiment, Scenario → Scene: what stands there before anything is planned. The
// true canvas, the arm as the program knows it, the simulated world around both, and what the depth
// cameras saw of it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/perception/normals.h"
#include "impedraw/planning/surface_height.h"
#include "impedraw/settings/setting_error.h"
#include "impedraw/simulation/world.h"

namespace impedraw {

struct Scene {
  std::unique_ptr<Canvas> canvas;              // the truth
  ArmModel arm;                                // as the controller believes it to be
  JointVector start_q;                         // tip at arm.start, pen along the drawing axis [rad]
  std::unique_ptr<World> world;                // at the start posture
  std::optional<SurfaceEstimator> perception;  // absent: blind
  // The same cloud for the planner, which is to stay clear of its edges: they are told from nearer.
  std::optional<SurfaceEstimator> planning;
  BlindSettings blind;             // what is known of the height where nothing is seen
  std::vector<std::string> notes;  // what was repaired in the canvas's file; a line each

  // The surface that the planner goes by, in P: the cloud, or blind what is known. Refers to the
  // scene.
  SurfaceHeight surface(const Pose& X_WP) const;
};

// The arm starts upright to the drawing plane of X_WP. Throws InputError: a canvas or an arm that
// cannot be, a start out of reach, too little of the canvas in view.
Scene build_scene(const Scenario& scenario, const Pose& X_WP, const SettingErrors& setting_errors);

}  // namespace impedraw

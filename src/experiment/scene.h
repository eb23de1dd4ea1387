// Stage 2 of an experiment, Scenario → Scene: the true canvas, the controller's arm model, the
// simulated world with both, and the depth cameras' view of the canvas.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/perception/plan_surface.h"
#include "impedraw/planning/surface_height.h"
#include "impedraw/settings/setting_error.h"
#include "impedraw/simulation/world.h"

namespace impedraw {

struct Scene {
  std::shared_ptr<Canvas> canvas;  // the truth
  ArmModel arm;                    // the controller's model
  JointVector start_q;             // tip at arm.start, pen along the drawing axis [rad]
  std::unique_ptr<World> world;    // at the start posture
  std::shared_ptr<const SurfaceEstimator> perception;  // null: blind
  // The same cloud for the planner, with a stricter edge test to keep the plan clear of its edges.
  std::shared_ptr<const PlanSurface> planning;
  // The planner's surface, in P: from the cloud, or without perception the assumed height: the
  // canvas's or, where that is unknown, the upper level of where it may be. It keeps what it reads,
  // so that a copy may outlive the scene.
  SurfaceHeight surface;
  // The seen surface as small facets around the cloud's points, which the arm must not touch;
  // without perception the true canvas. Never null.
  std::shared_ptr<const Canvas> obstacle;
  BlindSettings blind;             // the assumed height without perception
  std::vector<std::string> notes;  // repairs to the canvas's file, one line each

  // Knowledge of the controller and the planner about the surface.
  bool by_touch() const { return !perception && blind.height == BlindHeight::touch; }
  bool height_unknown() const { return !perception && blind.height != BlindHeight::canvas; }
  // The controller has an estimate of the surface under the tip.
  bool estimates_surface() const { return perception != nullptr || by_touch(); }
};

// The simulated world is made of what was seen: there is no truth to judge against.
bool is_rehearsal(const Scenario& scenario);

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

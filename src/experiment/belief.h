// The belief about arm and canvas: the only view of the world that the plan, the control set-up and
// the loop have. The true canvas and the simulated world are apart (truth.h).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/perception/camera_correction.h"
#include "impedraw/perception/plan_surface.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

struct Belief {
  ArmModel arm;         // the controller's model
  JointVector start_q;  // tip at arm.start, pen along the drawing axis [rad]
  std::shared_ptr<const SurfaceEstimator> perception;  // null: blind
  // The same cloud for the planner, with a stricter edge test to keep the plan clear of its edges.
  std::shared_ptr<const PlanSurface> planning;
  // The planner's surface, in P: from the cloud, or without perception the assumed height: the
  // canvas's or, where that is unknown, the upper level of where it may be. It keeps what it reads,
  // so that a copy may outlive the belief.
  SurfaceHeight surface;
  // The seen surface as small facets around the cloud's points, which the arm must not touch;
  // without perception the canvas as it was set up. Never null.
  std::shared_ptr<const Canvas> obstacle;
  BlindSettings blind;             // the assumed height without perception
  std::vector<std::string> notes;  // repairs to the canvas's file, one line each
  // The error of each camera, or view of a capture, by the snapshot; empty: none.
  std::vector<CameraCorrection> camera_corrections;

  // Knowledge of the controller and the planner about the surface.
  bool by_touch() const { return !perception && blind.height == BlindHeight::touch; }
  bool height_unknown() const { return !perception && blind.height != BlindHeight::canvas; }
  // The controller has an estimate of the surface under the tip.
  bool estimates_surface() const { return perception != nullptr || by_touch(); }
};

}  // namespace impedraw

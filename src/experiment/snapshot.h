// The single snapshot that the depth cameras take of canvas and arm before drawing.
#pragma once

#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/perception/camera_correction.h"
#include "impedraw/simulation/world.h"

namespace impedraw {

struct Snapshot {
  SurfaceEstimator seen;
  PointCloud beside;  // thinned: what find_canvas left out, which the arm must not touch either
  std::vector<CameraCorrection> corrections;  // of each camera or view; empty: none
};

// The cameras' view of the canvas. The arm is at q; its points are removed from the cloud. Where
// frames follow, and the marks are off by more than their noise, each camera is put where they tell
// that it stands. Images with a stereo camera's faults are treated as a capture's. Appends to
// `notes` what was found. Throws InputError without cameras, or with too little of the canvas in
// view.
Snapshot take_snapshot(const Scenario& scenario, const Canvas& canvas, const World& world,
                       ArmModel& arm, const JointVector& q, std::vector<std::string>* notes);

// The view in perception.capture or perception.cloud. Appends to `notes` what it gave and what was
// removed, one line each. `placed`: DrawnAbout's. Throws InputError if it is invalid or shows too
// little.
Snapshot read_snapshot(const Scenario& scenario, const Pose& X_WP, bool placed, ArmModel& arm,
                       std::vector<std::string>* notes);

}  // namespace impedraw

// The single snapshot that the depth cameras take of canvas and arm before drawing.
#pragma once

#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/simulation/world.h"

namespace impedraw {

// The camera that takes the images, where points are computed with the one that is believed in; the
// directions of its errors come from the seed.
DepthCamera true_camera(const DepthCamera& believed, const CameraErrors& errors,
                        std::uint64_t seed);
// The seed of a camera's errors and noise.
std::uint64_t camera_seed(const Scenario& scenario, std::size_t camera);

struct Snapshot {
  SurfaceEstimator seen;
  PointCloud beside;  // thinned: what find_canvas left out, which the arm must not touch either
};

// The cameras' view of the canvas. The arm is at q; its points are removed from the cloud.
// Throws InputError without cameras, or with too little of the canvas in view.
Snapshot take_snapshot(const Scenario& scenario, const Canvas& canvas, const World& world,
                       ArmModel& arm, const JointVector& q);

// The view in perception.capture or perception.cloud. Appends to `notes` what it gave and what was
// removed, one line each. `placed`: DrawnAbout's. Throws InputError if it is invalid or shows too
// little.
Snapshot read_snapshot(const Scenario& scenario, const Pose& X_WP, bool placed, ArmModel& arm,
                       std::vector<std::string>* notes);

}  // namespace impedraw

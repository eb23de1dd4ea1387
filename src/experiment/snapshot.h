// The single snapshot that the depth cameras take of canvas and arm before drawing.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/perception/camera_correction.h"
#include "impedraw/perception/stereo_faults.h"
#include "impedraw/simulation/world.h"

namespace impedraw {

// A simulated depth camera: how it is believed to stand and see, and how it does
// (CameraErrors, perception.stereo). The directions of its errors come from the seed.
class SimulatedCamera {
 public:
  // Number `number` of perception.cameras, with images of its own size or of another one [px].
  SimulatedCamera(const Scenario& scenario, std::size_t number);
  SimulatedCamera(const Scenario& scenario, std::size_t number, int width, int height);

  const DepthCamera& believed() const { return believed_; }
  void correct(const CameraCorrection& correction) {
    believed_.X_WC = correction.T * believed_.X_WC;
    marks_off_ = correction.marks;
  }
  const DepthCamera& actual() const { return actual_; }
  std::uint64_t seed() const { return seed_; }

  // Its measurement, in all threads; or a part of the image, in this one, with another seed.
  DepthImage image(const CastRays& cast_rays) const;
  void render(const CastRays& cast_rays, std::uint64_t seed, const PixelBox& part,
              DepthImage* image) const;
  // The pixels that may see a box, and some beside it.
  PixelBox part(const Eigen::AlignedBox3d& box, const Pose& X_WB) const;

  // A mark at p_W is in the image, and neither the arm nor the canvas, at X_WK, hides it.
  bool sees(const Eigen::Vector3d& p_W, const World& world, const Canvas& canvas,
            const Pose& X_WK) const noexcept;
  // The place at which this camera finds mark `number`, without noise [m].
  Eigen::Vector3d found_at(const Eigen::Vector3d& p_W, std::size_t number) const noexcept;

 private:
  DepthCamera believed_, actual_;
  std::uint64_t seed_;
  StereoFaults faults_;
  DepthNoise noise_;
  double depth_scale_;
  std::vector<Eigen::Vector3d> marks_off_;
};

// The seed of a camera's errors and noise.
std::uint64_t camera_seed(const Scenario& scenario, std::size_t camera);

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

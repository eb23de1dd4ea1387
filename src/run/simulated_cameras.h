// Cameras that keep capturing a canvas that moves: its frames appear at their simulated time.
//
// Camera c exposes its frame k at k / rate + c · skew, at the next cycle of the world. Each mark
// that is in its image, and that neither arm nor canvas hide, is found with noise. The frame
// arrives after `latency`, normally distributed with `latency_jitter` and never before the
// exposure, or, with probability `drop`, never. With perception.frames.depth it has the depth of
// each pixel on the canvas, or on the arm before it.
#pragma once

#include <cstdint>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/common/seeded_normals.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/perception/canvas_tracker.h"
#include "impedraw/perception/depth_camera.h"
#include "impedraw/simulation/world.h"

namespace impedraw {

class SimulatedCameras {
 public:
  // Refers to world, canvas and arm.
  SimulatedCameras(const Scenario& scenario, World& world, const Canvas& canvas, ArmModel& arm);

  // Once per cycle, at the world's state. lost: what is exposed now never arrives.
  void expose(bool lost) noexcept;
  // The next of the frames that have arrived by `time`. Returns false if there is none.
  bool next(double time, CanvasFrame* frame) noexcept;

 private:
  struct Camera {
    DepthCamera believed, actual;
    std::uint64_t exposed = 0;  // frames
    std::uint64_t seed = 0;
    SeededNormals noise;
  };
  struct Coming {
    double arrives = 0.0;
    CanvasFrame frame;
    DepthImage image;
    std::vector<Capsule> arm;
  };

  void capture(int camera, double time, bool lost) noexcept;
  bool sees(const DepthCamera& camera, const Eigen::Vector3d& p_W, const Pose& X_WK) const noexcept;

  void take_image(const Camera& camera, const Pose& X_WK, Coming* coming) const;

  World& world_;
  const Canvas& canvas_;
  ArmModel& arm_;
  DepthNoise noise_;
  double depth_scale_;
  FrameSettings frames_;
  FiducialSettings fiducials_;
  std::vector<Camera> cameras_;
  std::vector<Coming> coming_;
  Coming given_;  // the last that next() gave
};

}  // namespace impedraw

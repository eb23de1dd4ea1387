// Cameras that keep capturing a canvas that moves: its frames appear at their simulated time.
//
// Camera c exposes its frame k at k / rate + c · skew, at the next cycle of the world. Each mark
// that is in its image, and that neither arm nor canvas hide, is found with noise. The frame
// arrives after `latency`, normally distributed with `latency_jitter` and never before the
// exposure, or, with probability `drop`, never. With perception.frames.depth it has the depth of
// each pixel on the canvas, or on the arm before it.
//
// A second thread renders the depths between exposure and arrival; what it has not begun by then,
// this one does. The images are the same with any number of threads. Rays that cannot meet the
// canvas are left out.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/common/exchange.h"
#include "impedraw/common/seeded_normals.h"
#include "impedraw/experiment/snapshot.h"
#include "impedraw/perception/canvas_frame.h"
#include "impedraw/simulation/world.h"

namespace impedraw {

class SimulatedCameras {
 public:
  // Refers to world and canvas. corrections: Belief's, of the cameras. threads: 1 or 2; 0: 2, where
  // the machine has as many.
  SimulatedCameras(const Scenario& scenario, World& world, const Canvas& canvas,
                   const ArmModel& arm, const std::vector<CameraCorrection>& corrections,
                   int threads = 0);
  ~SimulatedCameras();
  SimulatedCameras(const SimulatedCameras&) = delete;
  SimulatedCameras& operator=(const SimulatedCameras&) = delete;

  // Once per cycle, at the world's state. lost: what is exposed now never arrives.
  void expose(bool lost) noexcept;
  // The next of the frames that have arrived by `time`. Returns false if there is none. Waits until
  // its depths are rendered.
  bool next(double time, CanvasFrame* frame) noexcept;

 private:
  struct Camera {
    SimulatedCamera camera;
    std::uint64_t exposed = 0;  // frames
    SeededNormals noise;
  };
  // The data that its image needs stay as it was at the exposure.
  struct Coming {
    double arrives = 0.0;
    CanvasFrame frame;
    bool has_depth = false;
    std::uint64_t seed = 0;
    Pose X_WK;
    PosedBody body;
    std::vector<Capsule> arm;
    DepthImage image;
    // State of the image: whoever turns waiting into begun renders it.
    enum Stage { waiting, begun, done };
    std::atomic<int> stage = done;
  };

  void capture(int camera, double time, bool lost) noexcept;
  Coming* unused();
  void render_if_waiting(Coming* coming) const noexcept;
  void render_what_is_queued() noexcept;  // the second thread

  World& world_;
  const Canvas& canvas_;
  ArmModel arm_;
  double time_stamp_;
  FrameSettings frames_;
  FiducialSettings fiducials_;
  std::vector<Camera> cameras_;
  std::vector<std::unique_ptr<Coming>> all_;
  std::vector<Coming*> unused_, coming_;  // coming_: in order of arrival
  Coming* given_ = nullptr;               // the last that next() gave

  Queue<Coming*, 1024> queue_;
  std::atomic<unsigned> posted_ = 0;  // changes with the queue, and at the end
  std::atomic<bool> ends_ = false;
  std::thread second_;
};

}  // namespace impedraw

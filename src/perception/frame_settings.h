// Cameras that keep capturing: when frames are taken, when they arrive, and what is found in them
// besides depths.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/common/range.h"

namespace impedraw {

struct FrameSettings {
  bool enabled = false;          // off: one snapshot before drawing
  double rate = 30.0;            // of each camera [Hz]
  double latency = 0.06;         // from exposure to the points being usable, mean [s]
  double latency_jitter = 0.01;  // its standard deviation [s]
  double drop = 0.05;            // share of the frames that never arrive
  // Time to subtract from each frame's time stamp, so that it tells the exposure: found by
  // ./impedraw arm camera-latency [s].
  double stamp_error = 0.0;
  // From one camera's exposure to the next one's, of the same frame [s].
  double skew = 0.0;
  // Switches to measure the worth of each: off, the pen goes where the canvas was at the last
  // frame, or without the canvas's velocity and acceleration.
  bool prediction = true, feedforward = true;
  // A canvas that is moved by hand between strokes: the pen waits above it until it stands.
  bool wait_for_rest = false;
  // Every depth_every-th frame carries depths, in which the canvas's shape is found.
  bool depth = false;
  int depth_every = 1;
  bool grow_surface = true;       // the surface under the pen improves with the depths
  int width = 320, height = 240;  // of a frame; the snapshot has the camera's own size
};

// A mark on the canvas's frame, at p_K in frame K of the canvas; K is W while nothing has moved.
struct Fiducial {
  Eigen::Vector3d p_K = Eigen::Vector3d::Zero();  // [m]
};

// Each camera finds each of them in each frame, unless the arm hides it.
struct FiducialSettings {
  std::vector<Fiducial> points;
  double noise = 0.3e-3;  // standard deviation of each axis of a point found [m]

  struct Limits {
    static constexpr Limit noise = {"noise", "m", {0.0, 0.05}};
  };
};

// The controller's source of the canvas's pose.
enum class CanvasPoseSource {
  tracked,  // from the frames
  truth     // from the simulator: to judge the controller alone
};

// Time for which the arm watches the canvas before the first stroke [s].
inline constexpr double kWatchTime = 6.0;
inline constexpr Limit kWatchLimit = {"watch", "s", {0.0, 600.0}};

}  // namespace impedraw

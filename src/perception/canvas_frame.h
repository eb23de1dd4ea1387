// A view of the canvas from a camera that keeps capturing.
#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "impedraw/perception/cloud.h"
#include "impedraw/perception/depth_camera.h"

namespace impedraw {

// A mark that a camera found.
struct FoundMark {
  int mark = 0;                                   // index into FiducialSettings::points
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  // [m]
};

// A camera's view of the canvas at one time.
struct CanvasFrame {
  static constexpr int kMostMarks = 16;

  double time = 0.0;  // of its exposure as its stamp tells it, on the driver's clock [s]
  int camera = 0;
  int count = 0;  // of marks
  std::array<FoundMark, kMostMarks> marks{};
  // Depths, where the camera gives them, with the camera as it is believed to stand, and the arm at
  // the time of the exposure. Valid until the next frame is taken.
  const DepthImage* depth = nullptr;
  const DepthCamera* camera_model = nullptr;
  std::span<const Capsule> arm;

  std::span<const FoundMark> found() const noexcept {
    return {marks.data(), static_cast<std::size_t>(count)};
  }
};

}  // namespace impedraw

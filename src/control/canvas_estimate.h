// Place and motion of the canvas, as perception estimates it for the controller.
#pragma once

#include <Eigen/Core>

#include "impedraw/control/moving_frame.h"

namespace impedraw {

enum class CanvasStatus {
  ok,
  undetermined,  // along some direction neither shape nor fiducials tell the pose
  stale,         // the last frame that was understood is too old, or the covariance too large
  lost,          // no pose at all
};

// K coincides with W at the first estimate. The motion is a prediction, from the last frame to the
// time that was asked for.
struct CanvasEstimate {
  CanvasStatus status = CanvasStatus::lost;
  FrameMotion motion;
  double age = 0.0;  // of the last frame that was understood [s]
  // Covariance of the predicted pose, in W: turning about K's centre of observation, then its
  // displacement [rad², rad m, m²]
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();  // that centre [m]
};

}  // namespace impedraw

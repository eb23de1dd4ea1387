// Error of a camera as a snapshot found it, beyond what is believed of it.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/common/pose.h"

namespace impedraw {

struct CameraCorrection {
  Pose T;  // T X_WC is where it stands
  // Remaining error of each mark, seen from there, by the lens and the depths [m]; empty: none.
  std::vector<Eigen::Vector3d> marks;
};

}  // namespace impedraw

// What a snapshot found a camera to be off, beyond what is believed of it.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "impedraw/common/pose.h"

namespace impedraw {

struct CameraCorrection {
  Pose T;  // T X_WC is where it stands
  // How far off each mark is still found from there, which the lens and the depths are to blame
  // for [m]; empty: none.
  std::vector<Eigen::Vector3d> marks;
};

}  // namespace impedraw

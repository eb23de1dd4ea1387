// The points of a capture's views: cleaned, without the arm, cropped.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "impedraw/capture/capture.h"
#include "impedraw/perception/cloud.h"

namespace impedraw {

// The arm's shapes at some joint positions [rad].
using ArmShapes = std::function<std::vector<Capsule>(const std::vector<double>&)>;

struct CaptureCloud {
  PointCloud cloud;                // not thinned; `camera` counts the views
  std::vector<std::string> notes;  // what each view gave and what was removed, one line each
};

// Each view's points lie in W. The arm is removed where a view tells its joints. Throws InputError
// if no view has a point in the region.
CaptureCloud cloud_of(Capture capture, const CloudSettings& settings, const ArmShapes& arm);

}  // namespace impedraw

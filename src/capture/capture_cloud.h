// The points of a capture's views, cleaned, put onto each other, without the arm and cropped; and
// those of a cloud's file.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "impedraw/capture/capture.h"
#include "impedraw/capture/cloud_file.h"
#include "impedraw/capture/view_alignment.h"
#include "impedraw/perception/cloud.h"

namespace impedraw {

// The arm's shapes at some joint positions [rad].
using ArmShapes = std::function<std::vector<Capsule>(const std::vector<double>&)>;

struct CaptureCloud {
  PointCloud cloud;                // not thinned; `camera` counts the views
  std::vector<std::string> notes;  // what each view gave and what was removed, one line each
  ViewAlignment alignment;         // of several views
  std::vector<std::string> views;  // names of those of a capture
};

// The points of a file `name` that lie in the region, as seen from `viewpoints`, or from where the
// file says, or from 1 m above their middle. Where the file's normals agree among neighbours, so
// that they tell outside from inside, a point was seen from the viewpoint that its normal looks at
// most directly, and points that face away from all of them go; else from the nearest viewpoint.
// Throws InputError if no point is left.
CaptureCloud cloud_of(const CloudFile& file, const std::string& name,
                      const std::vector<Eigen::Vector3d>& viewpoints,
                      const CloudSettings& settings);

// Each view's points lie in W. Several views are put onto each other (view_alignment.h) if
// `aligned` says so. The arm is removed where a view tells its joints. Throws InputError if no view
// has a point in the region, if a view is too far off the others, and if a camera lies inside of
// what the views show.
CaptureCloud cloud_of(Capture capture, const CloudSettings& settings, const ArmShapes& arm,
                      bool aligned = true);

}  // namespace impedraw

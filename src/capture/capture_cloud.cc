#include "impedraw/capture/capture_cloud.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "impedraw/capture/clean_view.h"
#include "impedraw/common/errors.h"

namespace impedraw {

CaptureCloud cloud_of(Capture capture, const CloudSettings& settings, const ArmShapes& arm) {
  CaptureCloud result;
  result.notes = std::move(capture.notes);
  PointCloud& cloud = result.cloud;
  for (std::size_t v = 0; v < capture.views.size(); ++v) {
    CapturedView& view = capture.views[v];
    const CleanedCounts counts = clean(&view);
    std::vector<Capsule> body;
    if (!view.joints.empty()) body = arm(view.joints);
    cloud.eyes.push_back(view.X_WC.p);
    int outside = 0, of_arm = 0, without_ray = 0, used = 0;
    for (int j = 0; j < view.lens.height; ++j) {
      for (int i = 0; i < view.lens.width; ++i) {
        const double depth = view.depth.at(i, j);
        if (!std::isfinite(depth)) continue;
        const auto direction = view.lens.direction_C(i, j);
        if (!direction) {
          ++without_ray;
          continue;
        }
        const Eigen::Vector3d p = view.X_WC * Eigen::Vector3d(depth * *direction);
        const auto hides = [&](const Capsule& c) { return inside(c, settings.self_padding, p); };
        if (!settings.region.contains(p)) {
          ++outside;
        } else if (std::any_of(body.begin(), body.end(), hides)) {
          ++of_arm;
        } else {
          ++used;
          cloud.points.push_back(p);
          cloud.camera.push_back(static_cast<int>(v));
        }
      }
    }
    result.notes.push_back(fmt::format(
        "{}: {} of {} pixels measured something; {} are used, {} lie outside perception.region, "
        "{} beside edges, {} in specks, {} on the arm{}",
        view.name, counts.measured, view.depth.depth.size(), used, outside, counts.edges,
        counts.specks, of_arm,
        without_ray ? fmt::format(", {} where the distortion has no inverse", without_ray) : ""));
  }
  if (cloud.points.empty()) {
    std::string text = "perception.capture: no view has a point within perception.region";
    for (const std::string& note : result.notes) text += "; " + note;
    throw InputError(text);
  }
  return result;
}

}  // namespace impedraw

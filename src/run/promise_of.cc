#include "impedraw/run/promise_of.h"

#include <algorithm>
#include <cmath>

#include "impedraw/experiment/plan_summary.h"

namespace impedraw {

Promise promise_of(const PlannedDrawing& e) {
  Promise p;
  p.asked = plane_length(e.artwork.strokes);
  p.promised = plane_length(e.plan.strokes);
  p.undrawable = length_not_drawable(e);
  p.unnamed = unnamed_length(e);
  for (const Finding& f : e.plan.preflight.findings) ++p.problems[name_of(f.problem)];
  double least = 1.0;
  for (const Eigen::Vector3d& p_W : e.plan.target.points)
    least = std::min(least, e.scene.canvas->closest(p_W).n_W.z());
  p.slope = std::acos(std::clamp(least, -1.0, 1.0));
  p.time = e.plan.path.duration();
  p.axis_W = e.artwork.X_WP.R.col(2);
  return p;
}

double unnamed_length(const PlannedDrawing& e) {
  std::vector<StrokePart> told;
  for (StrokePart part : e.plan.preflight.drawable) {
    part.stroke = e.plan.source[static_cast<std::size_t>(part.stroke)];
    told.push_back(part);
  }
  for (const Finding& f : e.plan.preflight.findings) told.push_back(f.part);
  double sum = 0.0;
  for (const StrokePart& part : rest_of(e.artwork.strokes, told)) sum += part.length();
  return sum;
}

}  // namespace impedraw

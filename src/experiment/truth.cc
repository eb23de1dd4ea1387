#include "impedraw/experiment/truth.h"

#include <utility>

#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/promise_of.h"

namespace impedraw {

namespace {

// Defined everywhere: beside the canvas, the line goes on as planned, or level.
SurfaceHeight judged_surface(const Belief& belief, const Truth& truth, const Pose& X_WP) {
  if (belief.perception) return nearest_sheet(truth.canvas, X_WP, belief.surface);
  return SurfaceHeight([canvas = canvas_height(truth.canvas, X_WP), planned = belief.surface](
                           double x, double y, SurfaceHeight::Sample& last) {
    SurfaceHeight::Sample sample = canvas(x, y);
    if (!sample) sample = planned(x, y);
    if (!sample) sample = SurfaceSample{{x, y, last ? last->p_P.z() : 0.0}};
    last = sample;
    return sample;
  });
}

// A wrap is judged by the cells that the plan laid flat: those about what is promised alone make
// another map.
std::vector<PlacedStroke> desired_strokes(const PlannedDrawing& e, const SurfaceHeight& judged) {
  const Plan& plan = e.plan;
  if (!plan.wrap) return plan.preflight.findings.empty() ? e.artwork.desired : plan.strokes;
  std::vector<PlacedStroke> desired = plan.strokes;
  if (!e.belief.perception) return desired;
  for (PlacedStroke& stroke : desired)
    for (std::size_t i = 0; i < stroke.page.size(); ++i)
      stroke.p_P[i] = e.artwork.placement.to_plane(stroke.page[i]);
  return plan.wrap->laid_on(judged).wrap(desired).strokes;
}

}  // namespace

TargetLine target_of(const PlannedDrawing& e, const Truth& truth, const PrepareProgress& progress) {
  const SurfaceHeight judged = judged_surface(e.belief, truth, e.artwork.X_WP);
  const std::vector<PlacedStroke> desired = desired_strokes(e, judged);
  const double looks =
      2.0 * plane_length(desired) / TargetSettings().spacing + static_cast<double>(desired.size());
  const auto tell = [&](double share) { progress("projecting the target", 0.9 + 0.08 * share); };
  TargetLine target = project_target(desired, progress ? counted(judged, looks, tell) : judged);
  for (Eigen::Vector3d& p : target.points) p = e.artwork.X_WP * p;
  return target;
}

Yardstick yardstick_of(const PlannedDrawing& e, const Truth& truth,
                       const PrepareProgress& progress) {
  TargetLine target = target_of(e, truth, progress);
  Promise promise = promise_of(e, truth, target);
  return {std::move(target), truth.canvas->mesh(), truth.canvas,
          truth.world->canvas_motion().moves(), std::move(promise)};
}

}  // namespace impedraw

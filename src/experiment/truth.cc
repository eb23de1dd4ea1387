#include "impedraw/experiment/truth.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "impedraw/experiment/cover.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/plan_summary.h"

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
// another map. Strokes that the plan cut have other numbers than the artwork's.
std::vector<PlacedStroke> desired_strokes(const PlannedDrawing& e, const SurfaceHeight& judged) {
  const Plan& plan = e.plan;
  if (!plan.wrap)
    return plan.preflight.findings.empty() && !plan.laid ? e.artwork.desired() : plan.strokes;
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

Promise promise_of(const PlannedDrawing& e, const Truth& truth, const TargetLine& target) {
  Promise p;
  p.asked = plane_length(e.artwork.strokes);
  p.promised = plane_length(e.plan.strokes);
  if (e.plan.wrap && p.promised > 0.0) {
    double flat = 0.0;
    for (const StrokePart& part : e.plan.preflight.drawable)
      flat += on_artwork(e.plan, e.artwork.placement, part).length();
    p.flat = flat / std::exchange(p.promised, flat);
  }
  p.undrawable = length_not_drawable(e);
  p.unnamed = unnamed_length(e);
  if (!e.plan.wrap) p.reachable = reachable_length(e, truth);
  for (const Finding& f : e.plan.preflight.findings) {
    ++p.problems[name_of(f.problem)];
    p.lengths[name_of(f.problem)] += f.part.length();
  }
  p.asks_ink = touches(e.scenario);
  if (const auto pad = covering(e.scenario); pad && pad->joints > 0) p.face = pad->radius;
  double least = 1.0;
  for (const Eigen::Vector3d& p_W : target.points)
    least = std::min(least, truth.canvas->closest(p_W).n_W.z());
  p.slope = std::acos(std::clamp(least, -1.0, 1.0));
  p.time = e.plan.path.duration();
  p.axis_W = e.artwork.X_WP.R.col(2);
  return p;
}

double reachable_length(const PlannedDrawing& e, const Truth& truth) {
  constexpr double step = 1e-3, least_cosine = 0.2588;  // of 75°
  const Canvas& canvas = *truth.canvas;
  const Eigen::AlignedBox3d& box = canvas.bounds();
  const Eigen::Vector3d axis_W = e.artwork.X_WP.R.col(2);
  double sum = 0.0;
  for (const PlacedStroke& stroke : e.artwork.strokes) {
    for (std::size_t i = 0; i + 1 < stroke.p_P.size(); ++i) {
      const Eigen::Vector2d a_P = stroke.p_P[i], piece_P = stroke.p_P[i + 1] - a_P;
      const int parts = std::max(1, static_cast<int>(std::ceil(piece_P.norm() / step)));
      for (int k = 0; k < parts; ++k) {
        const Eigen::Vector2d p_P = a_P + (k + 0.5) / parts * piece_P;
        const Eigen::Vector3d p_W = e.artwork.X_WP * Eigen::Vector3d(p_P.x(), p_P.y(), 0.0);
        const double above = (p_W - box.center()).norm() + box.diagonal().norm();
        const auto hit = canvas.ray(p_W + above * axis_W, -axis_W);
        if (hit && hit->n_W.dot(axis_W) > least_cosine) sum += piece_P.norm() / parts;
      }
    }
  }
  for (const Finding& f : e.plan.preflight.findings)
    if (f.problem >= Problem::out_of_reach && f.problem <= Problem::arm_collision)
      sum -= f.part.length();
  return std::max(0.0, sum);
}

double unnamed_length(const PlannedDrawing& e) {
  std::vector<StrokePart> told;
  for (const StrokePart& part : e.plan.preflight.drawable)
    told.push_back(on_artwork(e.plan, e.artwork.placement, part));
  for (const Finding& f : e.plan.preflight.findings) told.push_back(f.part);
  double sum = 0.0;
  for (const StrokePart& part : rest_of(e.artwork.strokes, told)) sum += part.length();
  return sum;
}

}  // namespace impedraw

#include "impedraw/run/loop_sources.h"

#include <algorithm>
#include <utility>

namespace impedraw {

namespace {

// The true motion, to judge the controller alone. Accelerations are central differences.
CanvasEstimate true_canvas(const CanvasMotion& motion, double time) {
  constexpr double kStep = 1e-4;  // [s]
  const auto origin_of = [&](double t, Eigen::Vector3d* v) {
    const CanvasMotion::State state = motion.at(t);
    *v = state.velocity_at(state.X_WK.p);
    return state;
  };
  Eigen::Vector3d v, before, after;
  const CanvasMotion::State now = origin_of(time, &v), earlier = origin_of(time - kStep, &before),
                            later = origin_of(time + kStep, &after);
  CanvasEstimate estimate;
  estimate.status = CanvasStatus::ok;
  estimate.motion = {now.X_WK, v, (after - before) / (2.0 * kStep), now.w,
                     (later.w - earlier.w) / (2.0 * kStep)};
  return estimate;
}

// Finds the canvas in the cameras' frames; null where none keeps capturing.
std::unique_ptr<CanvasTracker> canvas_tracker(const Experiment& e, const Pose& X_WK) {
  const PerceptionSettings& p = e.scenario.perception;
  if (!follows_canvas(e) || p.canvas_pose != CanvasPoseSource::tracked) return nullptr;
  std::unique_ptr<CanvasShape> shape;
  if (p.frames.depth) {
    CanvasShapeSettings settings;
    settings.points.sigma_at_1m = std::max(p.noise.sigma_at_1m, 1e-4);
    settings.self_padding = p.self_padding;
    shape = std::make_unique<CanvasShape>(e.scene.perception->cloud(), settings);
  }
  return std::make_unique<CanvasTracker>(
      CanvasTrackerSettings{
          .fiducials = p.fiducials, .prediction = p.frames.prediction, .X_WK = X_WK},
      std::move(shape));
}

}  // namespace

bool follows_canvas(const Experiment& e) {
  const PerceptionSettings& p = e.scenario.perception;
  if (!e.scene.perception) return false;
  return p.canvas_pose == CanvasPoseSource::tracked ? p.frames.enabled
                                                    : e.scene.world->canvas_motion().moves();
}

Disturbances disturbances_of(const Experiment& e, bool resumed) {
  return resumed ? Disturbances() : Disturbances(e.scenario, e.plan.path);
}

std::unique_ptr<CanvasWatch> canvas_watch(const Experiment& e, Driver& driver, const Pose& X_WK) {
  const PerceptionSettings& p = e.scenario.perception;
  std::unique_ptr<CanvasTracker> tracker = canvas_tracker(e, X_WK);
  if (!tracker) return nullptr;
  const bool lock_step = driver.info().waits;
  std::unique_ptr<GrowingSurface> surface;
  if (tracker->shape() && p.frames.grow_surface)
    surface = std::make_unique<GrowingSurface>(*e.scene.perception, p.normals, lock_step);
  return std::make_unique<CanvasWatch>(std::move(tracker), std::move(surface), driver,
                                       p.frames.stamp_error, lock_step);
}

SurfaceSource surface_source(const Experiment& e, Disturbances disturbances,
                             const GrowingSurface* growing) {
  if (!e.scene.perception) return {};
  return [&cloud = *e.scene.perception, growing, disturbances = std::move(disturbances)](
             const Eigen::Vector3d& p_W, double time) {
    SurfaceEstimate surface = growing ? growing->estimate(p_W) : cloud.estimate(p_W);
    if (disturbances.fault(FaultKind::no_cloud, time)) surface.status = SurfaceStatus::too_few;
    return surface;
  };
}

CanvasSource canvas_source(const Experiment& e, CanvasWatch* watch, double first_time) {
  if (watch)
    return [watch, feeds = e.scenario.perception.frames.feedforward](double time) {
      CanvasEstimate estimate = watch->follow(time);
      if (!feeds) estimate.motion = {.X_WK = estimate.motion.X_WK};
      return estimate;
    };
  const CanvasMotion& motion = e.scene.world->canvas_motion();
  if (follows_canvas(e))
    return [&motion, first_time](double time) { return true_canvas(motion, first_time + time); };
  return {};
}

}  // namespace impedraw

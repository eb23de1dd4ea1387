#include "impedraw/run/loop_sources.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "impedraw/run/streamed_capture.h"

namespace impedraw {
namespace {

// Finds the canvas in the cameras' frames. noise: of their depths, at 1 m [m].
std::unique_ptr<CanvasTracker> canvas_tracker(const Experiment& e, const Pose& X_WK, double noise) {
  const PerceptionSettings& p = e.scenario.perception;
  std::unique_ptr<CanvasShape> shape;
  if (p.frames.depth) {
    CanvasShapeSettings settings;
    settings.points.sigma_at_1m = std::max(noise, 1e-4);
    settings.self_padding = p.self_padding;
    shape = std::make_unique<CanvasShape>(e.belief.perception->cloud(), settings);
  }
  return std::make_unique<CanvasTracker>(
      CanvasTrackerSettings{
          .fiducials = p.fiducials, .prediction = p.frames.prediction, .X_WK = X_WK},
      std::move(shape));
}

}  // namespace

bool follows_canvas(const Experiment& e, const Driver& driver) {
  if (!e.belief.perception) return false;
  const PerceptionSettings& p = e.scenario.perception;
  FrameMotion motion;
  return p.canvas_pose == CanvasPoseSource::tracked ? p.frames.enabled
                                                    : driver.true_canvas(0.0, &motion);
}

Disturbances disturbances_of(const Experiment& e, bool resumed) {
  return resumed ? Disturbances() : Disturbances(e.scenario, e.plan.path);
}

std::unique_ptr<CanvasWatch> canvas_watch(const Experiment& e, Driver& driver, const Pose& X_WK) {
  const PerceptionSettings& p = e.scenario.perception;
  if (!e.belief.perception || p.canvas_pose != CanvasPoseSource::tracked || !p.frames.enabled)
    return nullptr;
  double noise = p.noise.sigma_at_1m;
  std::unique_ptr<FrameSource> frames = std::make_unique<DriverFrames>(driver);
  if (p.source == PerceptionSource::capture)
    frames = capture_frames(p, e.belief.arm, e.belief.camera_corrections, &noise);
  std::unique_ptr<CanvasTracker> tracker = canvas_tracker(e, X_WK, noise);
  const bool lock_step = driver.info().waits && !frames->streams();
  std::unique_ptr<GrowingSurface> surface;
  if (tracker->shape() && p.frames.grow_surface)
    surface = std::make_unique<GrowingSurface>(*e.belief.perception, p.normals, lock_step);
  return std::make_unique<CanvasWatch>(std::move(tracker), std::move(surface), std::move(frames),
                                       p.frames.stamp_error, lock_step);
}

SurfaceSource surface_source(const Experiment& e, Disturbances disturbances,
                             const GrowingSurface* growing) {
  if (!e.belief.perception) return {};
  return [&cloud = *e.belief.perception, growing, disturbances = std::move(disturbances),
          recent = RecentSurface()](const Eigen::Vector3d& p_W, double time) mutable {
    SurfaceEstimate surface = growing ? growing->estimate(p_W) : cloud.estimate(p_W, &recent);
    if (disturbances.fault(FaultKind::no_cloud, time)) surface.status = SurfaceStatus::too_few;
    return surface;
  };
}

CanvasSource canvas_source(const Experiment& e, CanvasWatch* watch, const Driver& driver) {
  if (watch)
    return [watch, feeds = e.scenario.perception.frames.feedforward](double time) {
      CanvasEstimate estimate = watch->follow(time);
      if (!feeds) estimate.motion = {.X_WK = estimate.motion.X_WK};
      return estimate;
    };
  if (!follows_canvas(e, driver)) return {};
  return [&driver](double time) {
    CanvasEstimate estimate;
    estimate.status = CanvasStatus::ok;
    driver.true_canvas(time, &estimate.motion);
    return estimate;
  };
}

double time_at(const TipPath& path, double share) {
  const auto& strokes = path.strokes();
  return strokes.front().start + share * (strokes.back().end - strokes.front().start);
}

Disturbances::Disturbances(const Scenario& scenario, const TipPath& path) {
  if (path.strokes().empty()) return;
  // The plan begins once the canvas was watched.
  const double watched = scenario.perception.frames.enabled ? scenario.perception.watch : 0.0;
  for (const FaultSettings& fault : scenario.faults) {
    const double start = watched + time_at(path, fault.start);
    faults_.push_back({fault.kind, start, start + fault.duration});
  }
  for (const PushSettings& push : scenario.pushes) {
    const double middle = watched + time_at(path, push.middle);
    if (push.link.empty()) {
      pushes_.push_back({push, middle});
    } else if (push.direction_W.norm() > 1e-9) {
      link_pushes_.push_back({push.link, push.force * push.direction_W.normalized(),
                              middle - 0.5 * push.duration, middle + 0.5 * push.duration});
    }
  }
}

double Disturbances::since(FaultKind kind, double time) const noexcept {
  for (const TimedFault& fault : faults_)
    if (fault.kind == kind && time >= fault.start && time < fault.end) return time - fault.start;
  return -1.0;
}

Eigen::Vector3d Disturbances::push(double time, const Eigen::Vector3d& n_W) const noexcept {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const auto& [push, middle] : pushes_) {
    if (std::abs(time - middle) > 0.5 * push.duration) continue;
    const Eigen::Vector3d along = push.direction_W - n_W * n_W.dot(push.direction_W);
    if (along.norm() > 1e-9) force += push.force * along.normalized();
    force += push.lift * n_W;
  }
  return force;
}

}  // namespace impedraw

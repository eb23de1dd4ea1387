#include "impedraw/run/monitors/block_monitor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace impedraw {
namespace {
constexpr double kAside = 1.0e-3;  // [m]
// A force across the normal that the law expects is no wall, also where the estimated normal is off
// by kNormalOff: between facets, and in a cloud's noise.
constexpr double kDegree = std::numbers::pi / 180.0, kNormalOff = 15.0 * kDegree,
                 kSteepest = 85.0 * kDegree;

// The place that holds the tip, from where it is to where the plan is.
std::optional<StrokePart> place_of_tip(const Cycle& cycle, const TipPath& path, double planned,
                                       bool ahead) {
  std::optional<StrokePart> place = place_on_path(cycle.desired, path, planned, ahead);
  if (place && cycle.desired.stroke >= 0) place->from -= cycle.behind().norm();
  return place;
}
}  // namespace

std::optional<StrokePart> place_on_path(const PathSample& desired, const TipPath& path,
                                        double planned, bool ahead) {
  if (desired.stroke >= 0) return StrokePart{desired.stroke, desired.along, desired.along};
  for (const StrokeTimes& stroke : path.strokes()) {
    if (planned > stroke.end || (!ahead && planned < stroke.approach)) continue;
    const double along = path.at(std::max(planned, stroke.start + 1e-4)).along;
    return StrokePart{stroke.number, along, along};
  }
  return std::nullopt;
}

BlockMonitor::BlockMonitor(const Experiment& e)
    : surface_(e.belief.perception ? &*e.belief.perception : nullptr),
      feels_(surface_ && e.control.impedance.wrench == WrenchFeedback::measured),
      touch_force_(e.control.impedance.contact.touch_force),
      side_(std::tan(std::min(
          kSteepest,
          kNormalOff + std::atan(std::hypot(
                           e.control.impedance.friction.coefficient,
                           std::tan(e.control.impedance.friction.normal_error_deg * kDegree)))))),
      deepest_(std::max(SinkMonitor::kDeepest, e.control.impedance.approach.overtravel - 1e-3)) {}

void BlockMonitor::begin_path() noexcept {
  wall_.reset();
  side_.reset();
  sink_.reset(deepest_);
}

Verdict BlockMonitor::judge(const Cycle& cycle, const TipPath& path, double planned, bool unseen,
                            std::optional<StrokePart>* place) {
  if (!feels_) return {};
  Verdict blocked{
      .severity = Severity::lift, .end = RunEnd::finished, .rise = Verdict::Rise::a_little};
  const ImpedanceTorque& out = cycle.out;
  const PathSample& desired = cycle.desired;
  const bool down = out.mode == ContactMode::contact || out.mode == ContactMode::approach;
  if (!down) {
    side_.reset();
    sink_.reset(deepest_);
  }
  const Eigen::Vector3d f = cycle.F_ext.head<3>();
  const bool sunk = down && !cycle.canvas.follows() && sinks(cycle);
  const bool aside = down && side_.update(out.n_WD, f, cycle.dt);
  const bool lost = lost_surface(cycle), shaft = cycle.state->shaft_touches;
  if (sunk || aside || lost || unseen || shaft) {
    *place = place_of_tip(cycle, path, planned, shaft);
    if (*place && sunk && (*place)->stroke == touched_.stroke)
      (*place)->from = std::min((*place)->from, touched_.from);
    if (aside && side_.caught())  // out from beneath what holds it
      blocked.aside_W = kAside * (f - out.n_WD * out.n_WD.dot(f)).normalized();
    if (*place) return blocked;
  }
  if (desired.stroke < 0 || out.mode != ContactMode::contact) {
    wall_.reset();
    return {};
  }
  const Eigen::Vector3d v_D = cycle.canvas.pose().R * desired.reference.v_WD;
  if (!wall_.update(out.n_WD, v_D, cycle.velocity_on_canvas(), cycle.behind(), f, cycle.dt))
    return {};
  *place = place_of_tip(cycle, path, planned, false);
  return blocked;
}

// True in the cycle in which the controller retreats from a place where the cameras have seen no
// surface: a gap between two bodies, for instance. A fault of perception does not count.
bool BlockMonitor::lost_surface(const Cycle& cycle) noexcept {
  const bool before = std::exchange(retreats_, cycle.out.mode == ContactMode::retreat);
  return retreats_ && !before && !cycle.canvas.follows() &&
         surface_->estimate(cycle.arm.X_WE.p).status != SurfaceStatus::ok;
}

bool BlockMonitor::sinks(const Cycle& cycle) noexcept {
  const Eigen::Vector3d& n = cycle.out.n_WD;
  const PathSample& desired = cycle.desired;
  const bool touches =
      cycle.out.mode == ContactMode::contact && cycle.normal_force() > touch_force_;
  if (touches) touched_ = {desired.stroke, desired.along, desired.along};
  const Eigen::Vector3d v = cycle.velocity_on_canvas();
  const double way = (v - n.dot(v) * n).norm() * cycle.dt;
  const bool sunk = sink_.update(cycle.surface.distance, way, touches, cycle.dt);
  if (sink_.held() && std::isfinite(cycle.surface.distance))
    deepest_ = SinkMonitor::kDeepest - std::min(0.0, cycle.surface.distance);
  return sunk;
}

}  // namespace impedraw

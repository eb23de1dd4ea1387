#include "impedraw/run/drawing_task.h"

#include <algorithm>
#include <cmath>

namespace impedraw {

double TouchedHeights::level(double x, double y) const noexcept {
  double level = top_;
  for (const Eigen::Vector3d& p : points_)
    level = std::min(level, p.z() + kMargin + kSteepest * std::hypot(p.x() - x, p.y() - y));
  return level;
}

namespace {

// Between the pen and the normal that has been learned, to which it turns at its own speed [rad].
double tilt_of_pen(const ControlLoop& loop) {
  const Eigen::Vector2d slope = loop.touch()->slope();
  const Eigen::Vector3d n = loop.touch()->axes() * Eigen::Vector3d(-slope.x(), -slope.y(), 1.0);
  return smallest_rotation(loop.terms().X_WE.R.col(2), -n.normalized()).norm();
}

}  // namespace

double longest_search(const ImpedanceSettings& control) {
  return control.approach.overtravel / control.approach.speed + 2.0;
}

TouchSearch::TouchSearch(const Experiment& e)
    : control_(e.control.impedance),
      X_PW_(e.artwork.X_WP.inverse()),
      lowest_(e.scenario.blind.plane_z),
      heights_(e.scenario.blind.top_z) {}

TipReference TouchSearch::at_touched_height(TipReference reference, ContactMode mode,
                                            const Eigen::Vector3d& p_WE) noexcept {
  const Eigen::Vector3d& z = control_.surface.drawing_axis_W;
  const bool on_surface = mode == ContactMode::approach || mode == ContactMode::contact;
  if (reference.pen_down && on_surface) height_ = z.dot(p_WE - reference.p_WD);
  reference.p_WD += height_ * z;
  return reference;
}

bool TouchSearch::update(const PathSample& desired, const ImpedanceTorque& out,
                         const ControlLoop& loop, PenDeviation* pen) noexcept {
  const bool contact = out.mode == ContactMode::contact;
  const bool searching = desired.phase == Phase::approach && !contact;
  const Eigen::Vector3d p_PE = X_PW_ * loop.terms().X_WE.p;
  if (contact) heights_.add(p_PE);
  searched_ = searching ? searched_ + control_.timing.dt : 0.0;
  if (searched_ > longest_search(control_)) return false;
  if (out.mode == ContactMode::approach && p_PE.z() < lowest_) return false;
  pen->waits = searching || (desired.stroke >= 0 && out.mode == ContactMode::approach);
  if (contact && desired.stroke >= 0) pen->tilt = tilt_of_pen(loop);
  return true;
}

}  // namespace impedraw

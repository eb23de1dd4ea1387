#include "impedraw/planning/preflight/clearance.h"

#include <algorithm>
#include <cmath>

namespace impedraw {

namespace {

using Eigen::Vector3d;

// extra search distance to the canvas, so that the result stays valid for several calls [m]
constexpr double kAhead = 0.03;

double distance_to_box(const Eigen::AlignedBox3d& box, const Vector3d& a, const Vector3d& b) {
  return box.exteriorDistance(Vector3d((a + b) / 2)) - (b - a).norm() / 2;
}

// Distance of the segment a–b from the canvas, at most `best`. Above `enough` it may be too large
// by a tenth of its excess over `radius`, plus 1 mm. Skips halves whose midpoint distance shows
// that they contain nothing nearer.
double segment_distance(const Canvas& canvas, const Vector3d& a, const Vector3d& b, double radius,
                        double enough, double best) {
  const Vector3d middle = (a + b) / 2;
  const double half = (b - a).norm() / 2;
  const auto nearest = canvas.closest(middle, best + half);
  if (!nearest) return best;
  const double distance = std::abs(nearest->distance);
  best = std::min(best, distance);
  const double desired = std::max(enough, radius + 0.9 * (best - radius) - 1e-3);
  if (half < 1e-4 || distance - half >= desired) return best;
  best = segment_distance(canvas, a, middle, radius, enough, best);
  return segment_distance(canvas, middle, b, radius, enough, best);
}

}  // namespace

Clearance::Clearance(const ArmModel& arm, const Canvas* canvas, std::optional<double> table_z,
                     double desired, double tip_length, const JointVector& q)
    : arm_(arm), canvas_(canvas), table_z_(table_z), desired_(desired), tip_length_(tip_length) {
  const Vector3d tip = arm_.tip_pose(q).p;
  const std::vector<BodyCapsule> here = arm_.body_capsules(q),
                                 moved = arm_.body_capsules((q.array() + 0.1).matrix());
  double nearest = 0.05;
  for (std::size_t i = 0; i < here.size(); ++i) {
    Body body;
    body.fixed = (here[i].a_W - moved[i].a_W).norm() + (here[i].b_W - moved[i].b_W).norm() < 1e-9;
    body.a_K = here[i].a_W;
    body.b_K = here[i].b_W;
    bodies_.push_back(body);
    const double to_tip = std::min((here[i].a_W - tip).norm(), (here[i].b_W - tip).norm());
    if (to_tip < nearest) nearest = to_tip, pen_ = static_cast<int>(i);
  }
}

double Clearance::canvas_distance(Body& body, const BodyCapsule& at, double near_enough) {
  const Vector3d a = X_KW_ * at.a_W, b = X_KW_ * at.b_W;
  const double moved = std::max((a - body.a_K).norm(), (b - body.b_K).norm());
  if (body.distance - moved >= near_enough) return near_enough;
  const double ahead = near_enough + kAhead;
  body.distance = distance_to_box(canvas_->bounds(), a, b);
  body.a_K = a;
  body.b_K = b;
  if (body.distance >= near_enough) return near_enough;
  const double found = segment_distance(*canvas_, a, b, at.radius, at.radius + desired_, ahead);
  body.distance = found < ahead ? at.radius + 0.9 * (found - at.radius) - 1.2e-3
                                : ahead;  // no axis point is nearer
  return std::min(found, near_enough);
}

Gap Clearance::arm(const JointVector& q) {
  Gap result;
  const std::vector<BodyCapsule> at = arm_.body_capsules(q);
  const auto take = [&result](double gap, const BodyCapsule& body, const char* obstacle) {
    if (gap < result.gap) result = {gap, body.link, obstacle, 0};
  };
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (static_cast<int>(i) == pen_) continue;
    if (canvas_ && (canvas_moves_ || !bodies_[i].fixed))
      take(canvas_distance(bodies_[i], at[i], at[i].radius + kFarEnough) - at[i].radius, at[i],
           "canvas");
    if (table_z_ && !bodies_[i].fixed)
      take(std::min(at[i].a_W.z(), at[i].b_W.z()) - at[i].radius - *table_z_, at[i], "table");
  }
  return result;
}

Gap Clearance::pen(const JointVector& q, const Pose& X_WE) {
  Gap result;
  if (pen_ < 0) return result;
  const BodyCapsule shaft = arm_.body_capsules(q)[pen_];
  const double to_a = (shaft.a_W - X_WE.p).norm(), to_b = (shaft.b_W - X_WE.p).norm();
  const Vector3d far = to_a > to_b ? shaft.a_W : shaft.b_W, along = (far - X_WE.p).normalized();
  const double length = std::max(to_a, to_b), bare = std::min(to_a, to_b);
  const double widens = shaft.radius / std::hypot(shaft.radius, bare);  // sin α
  const auto asked = [&](double h) {
    return std::min(shaft.radius, h * widens) + std::min(desired_, h * kPenOpening);
  };
  const auto take = [&](double gap, double h, const char* obstacle) {
    if (gap < result.gap) result = {gap, shaft.link, obstacle, h};
  };
  if (table_z_) {  // the gap is linear between these points
    for (double h : {tip_length_, shaft.radius / widens, desired_ / kPenOpening, length}) {
      h = std::clamp(h, std::min(tip_length_, length), length);
      take((X_WE.p + h * along).z() - *table_z_ - asked(h), h, "table");
    }
  }
  if (!canvas_) return result;
  // The gap decreases by at most this per metre of axis. Steps are as long as possible without
  // missing a contact.
  const double fastest = 1 + widens + kPenOpening;
  for (double h = std::min(tip_length_, length);;) {
    const double look = asked(h) + kFarEnough;
    const auto nearest = canvas_->closest(X_KW_ * (X_WE.p + h * along), look);
    const double gap = (nearest ? std::abs(nearest->distance) : look) - asked(h);
    take(gap, h, "canvas");
    if (h >= length) return result;
    h = std::min(length, h + std::max(gap / fastest, 1e-3));
  }
}

}  // namespace impedraw

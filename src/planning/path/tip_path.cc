#include "impedraw/planning/path/tip_path.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace impedraw {

using Eigen::Vector3d;

PathMove move_between(const Vector3d& from, const Vector3d& to, SpeedSpan limits) {
  const Vector3d way = to - from;
  limits.length = way.norm();
  return {way.normalized(), limits};
}

PathMove turn_between(const Vector3d& n, const Vector3d& to, SpeedSpan limits) {
  const Vector3d across = n.cross(to);
  limits.length = std::atan2(across.norm(), n.dot(to));
  return {across.norm() > 1e-9 ? across.normalized() : n.unitOrthogonal(), limits};
}

TipPath::TipPath(PathParts parts, const std::vector<int>& numbers, const Pose& X_WP,
                 std::vector<ForceProfile> forces)
    : parts_(std::move(parts)), strokes_(numbers.size()), forces_(std::move(forces)), X_WP_(X_WP) {
  const std::vector<PathLeg>& legs = parts_.legs;
  for (std::size_t i = 0; i < numbers.size(); ++i) strokes_[i].number = numbers[i];
  double approach = 0;
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const PathLeg& leg = legs[i];
    const double t = leg.start;
    if (leg.phase == Phase::approach && (i == 0 || legs[i - 1].phase != Phase::approach))
      approach = t;
    if (leg.counts) {
      StrokeTimes& s = strokes_[leg.stroke];
      if (s.end == 0) s.approach = approach, s.start = t;  // the first
      s.end = i + 1 < legs.size() ? legs[i + 1].start : parts_.duration;
      if (leg.splined) s.length += parts_.splines[leg.place].line.arc_length();
    }
  }
}

double TipPath::mean_speed() const noexcept {
  double time = 0;
  for (const StrokeTimes& stroke : strokes_) time += stroke.end - stroke.start;
  return time > 0 ? pen_down_length() / time : std::numeric_limits<double>::infinity();
}

double TipPath::pen_down_length() const noexcept {
  double sum = 0;
  for (const StrokeTimes& s : strokes_) sum += s.length;
  return sum;
}

// Heading of a leg, and what E's place differs by; in P.
void TipPath::lead(const PathLeg& leg, double since, TipReference* r) const noexcept {
  const ToolHeading& heading = *parts_.heading;
  const Vector3d n = r->n_WD;
  if (leg.splined) {
    constexpr double kNear = 2.5e-4;  // [m]
    const auto& [line, progress] = parts_.splines[leg.place];
    const SpeedState along = progress.at(since);
    const SplineHeading here = heading_at(line.at(along.x));
    const double before = std::max(0.0, along.x - kNear),
                 after = std::min(line.length(), along.x + kNear);
    const double bend =
        (heading_at(line.at(after)).turn - heading_at(line.at(before)).turn) / (after - before);
    r->x_WD = turned_about(n, here.t, heading.yaw);
    r->yaw_rate = here.turn * along.speed;
    r->yaw_acceleration = here.turn * along.acceleration + bend * along.speed * along.speed;
  } else {
    const PathSpin& turned = parts_.spins[&leg - parts_.legs.data()];
    const SpeedState spin = rest_to_rest(turned.progress, parts_.smoothing_time, since);
    const double way = turned.back ? -1.0 : 1.0;
    Vector3d x = turned.x;
    if (leg.turns) {
      const auto [axis, progress] = parts_.turn(leg);
      x = Eigen::AngleAxisd(rest_to_rest(progress, parts_.smoothing_time, since).x, axis) * x;
    }
    r->x_WD = turned_about(n, x, way * spin.x);
    r->yaw_rate = way * spin.speed;
    r->yaw_acceleration = way * spin.acceleration;
  }
  const Vector3d w = r->w_WD + r->yaw_rate * n, lever = heading.trail * r->x_WD;
  r->p_WD += lever;
  r->v_WD += w.cross(lever);
  r->a_WD += (r->alpha_WD + r->yaw_acceleration * n).cross(lever);
}

PathSample TipPath::at(double t) const noexcept {
  PathSample sample;
  if (parts_.legs.empty()) return sample;
  const bool done = t >= duration();
  t = std::clamp(t, 0.0, duration());
  const auto after =
      std::ranges::upper_bound(parts_.legs.begin() + 1, parts_.legs.end(), t, {}, &PathLeg::start);
  const PathLeg& leg = *std::prev(after);
  const double since = t - leg.start;

  if (!done && leg.counts) {
    sample.stroke = strokes_[leg.stroke].number;
    sample.along = leg.along;
  }
  sample.phase = done ? Phase::done : leg.phase;
  TipReference& reference = sample.reference;
  reference.pen_down = sample.phase == Phase::approach || sample.phase == Phase::draw;

  const Vector3d& n = parts_.normals[leg.normal];
  reference.n_WD = n;
  ForceSample force;
  const bool presses = reference.pen_down && !forces_.empty();
  if (leg.splined) {
    const auto& [line, progress] = parts_.splines[leg.place];
    const SpeedState along = progress.at(since);
    const SplinePoint s = line.at(along.x);
    if (presses) {
      force = forces_[leg.stroke].at(s.along);
      reference.force_rate = force.slope * s.dalong * along.speed;
    }
    if (sample.stroke >= 0) sample.along = s.along;
    const double squared = along.speed * along.speed;
    reference.p_WD = parts_.below + s.p;
    reference.v_WD = along.speed * s.dp;
    reference.a_WD = along.acceleration * s.dp + squared * s.ddp;
    if (!parts_.fixed_normals) {
      reference.n_WD = s.n;
      reference.w_WD = along.speed * s.n.cross(s.dn);
      reference.alpha_WD = s.n.cross(along.acceleration * s.dn + squared * s.ddn);
    }
  } else {
    reference.p_WD = parts_.points[leg.place];
    if (leg.moves) {
      const auto [direction, progress] = parts_.move(leg);
      SpeedState along;
      if (leg.evenly) {
        const SpeedSpan turn = parts_.turn(leg).progress;
        const double per_turn = progress.length / turn.length;
        along = rest_to_rest(turn, parts_.smoothing_time, since);
        along = {per_turn * along.x, per_turn * along.speed, per_turn * along.acceleration};
      } else {
        along = rest_to_rest(progress, parts_.smoothing_time, since);
      }
      reference.p_WD += along.x * direction;
      reference.v_WD = along.speed * direction;
      reference.a_WD = along.acceleration * direction;
    }
    if (presses) force = forces_[leg.stroke].at(leg.along);
  }
  reference.force = force.force;
  reference.depth = force.depth;
  if (leg.turns) {
    const auto [axis, progress] = parts_.turn(leg);
    const SpeedState turn = rest_to_rest(progress, parts_.smoothing_time, since);
    reference.n_WD = std::cos(turn.x) * n + std::sin(turn.x) * axis.cross(n);
    reference.w_WD = turn.speed * axis;
    reference.alpha_WD = turn.acceleration * axis;
  }
  if (parts_.heading) lead(leg, since, &reference);
  reference.p_WD = X_WP_.p + X_WP_.R * reference.p_WD;
  for (Eigen::Vector3d* v : {&reference.v_WD, &reference.a_WD, &reference.n_WD, &reference.w_WD,
                             &reference.alpha_WD, &reference.x_WD})
    *v = X_WP_.R * *v;
  return sample;
}

}  // namespace impedraw

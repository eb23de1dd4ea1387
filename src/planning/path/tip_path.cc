#include "impedraw/planning/path/tip_path.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace impedraw {

using Eigen::Vector3d;

const char* name_of(Phase phase) noexcept {
  constexpr const char* kNames[] = {"travel", "approach", "draw", "lift", "done"};
  return kNames[static_cast<int>(phase)];
}

TipPath::TipPath(std::vector<PathLeg> legs, std::vector<PathSpline> splines,
                 const std::vector<int>& numbers, const Pose& X_WP,
                 std::vector<ForceProfile> forces, std::optional<ToolHeading> heading)
    : legs_(std::move(legs)),
      splines_(std::move(splines)),
      strokes_(numbers.size()),
      forces_(std::move(forces)),
      heading_(std::move(heading)),
      X_WP_(X_WP) {
  for (std::size_t i = 0; i < numbers.size(); ++i) strokes_[i].number = numbers[i];
  std::vector<char> started(numbers.size(), 0);
  double t = 0, approach = 0;
  for (std::size_t i = 0; i < legs_.size(); ++i) {
    const PathLeg& leg = legs_[i];
    starts_.push_back(t);
    if (leg.pause) pauses_.push_back(t);
    if (leg.phase == Phase::approach && (i == 0 || legs_[i - 1].phase != Phase::approach))
      approach = t;
    if (leg.stroke >= 0) {
      StrokeTimes& s = strokes_[leg.stroke];
      if (!started[leg.stroke]) s.approach = approach, s.start = t, started[leg.stroke] = 1;
      s.end = t + leg.duration;
      if (leg.spline >= 0) s.length += splines_[leg.spline].arc_length();
    }
    t += leg.duration;
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
  const Vector3d n = r->n_WD;
  if (leg.spline >= 0) {
    constexpr double kNear = 2.5e-4;  // [m]
    const PathSpline& spline = splines_[leg.spline];
    const SpeedState along = leg.progress.at(since);
    const SplineHeading here = heading_at(spline.at(along.x));
    const double before = std::max(0.0, along.x - kNear),
                 after = std::min(spline.length(), along.x + kNear);
    const double bend =
        (heading_at(spline.at(after)).turn - heading_at(spline.at(before)).turn) / (after - before);
    r->x_WD = turned_about(n, here.t, heading_->yaw);
    r->yaw_rate = here.turn * along.speed;
    r->yaw_acceleration = here.turn * along.acceleration + bend * along.speed * along.speed;
  } else {
    const SpeedState spin = leg.spin.at(since);
    const double way = leg.spin_back ? -1.0 : 1.0;
    const Vector3d carried = Eigen::AngleAxisd(leg.turn.at(since).x, leg.turn_axis) * leg.x;
    r->x_WD = turned_about(n, carried, way * spin.x);
    r->yaw_rate = way * spin.speed;
    r->yaw_acceleration = way * spin.acceleration;
  }
  const Vector3d w = r->w_WD + r->yaw_rate * n, lever = heading_->trail * r->x_WD;
  r->p_WD += lever;
  r->v_WD += w.cross(lever);
  r->a_WD += (r->alpha_WD + r->yaw_acceleration * n).cross(lever);
}

PathSample TipPath::at(double t) const noexcept {
  PathSample sample;
  if (legs_.empty()) return sample;
  const bool done = t >= duration();
  t = std::clamp(t, 0.0, duration());
  const auto after = std::upper_bound(starts_.begin() + 1, starts_.end(), t);
  const auto index = static_cast<std::size_t>(after - starts_.begin()) - 1;
  const PathLeg& leg = legs_[index];
  const double since = t - starts_[index];

  if (!done && leg.stroke >= 0) {
    sample.stroke = strokes_[leg.stroke].number;
    sample.along = leg.along;
  }
  sample.phase = done ? Phase::done : leg.phase;
  TipReference& reference = sample.reference;
  reference.pen_down = leg.pen_down && !done;

  const SpeedState along = leg.progress.at(since);
  reference.p_WD = leg.p + along.x * leg.direction;
  reference.v_WD = along.speed * leg.direction;
  reference.a_WD = along.acceleration * leg.direction;
  reference.n_WD = leg.n;
  ForceSample force;
  const bool presses = leg.pressed >= 0 && reference.pen_down;
  if (presses && leg.spline < 0) force = forces_[leg.pressed].at(leg.along);
  if (leg.spline >= 0) {
    const SplinePoint s = splines_[leg.spline].at(along.x);
    if (presses) {
      force = forces_[leg.pressed].at(s.along);
      reference.force_rate = force.slope * s.dalong * along.speed;
    }
    if (sample.stroke >= 0) sample.along = s.along;
    const double squared = along.speed * along.speed;
    reference.p_WD = leg.p + s.p;
    reference.v_WD = along.speed * s.dp;
    reference.a_WD = along.acceleration * s.dp + squared * s.ddp;
    if (!leg.fixed_normal) {
      reference.n_WD = s.n;
      reference.w_WD = along.speed * s.n.cross(s.dn);
      reference.alpha_WD = s.n.cross(along.acceleration * s.dn + squared * s.ddn);
    }
  }
  reference.force = force.force;
  reference.depth = force.depth;
  if (leg.turn.duration() > 0) {
    const SpeedState turn = leg.turn.at(since);
    reference.n_WD = std::cos(turn.x) * leg.n + std::sin(turn.x) * leg.turn_axis.cross(leg.n);
    reference.w_WD = turn.speed * leg.turn_axis;
    reference.alpha_WD = turn.acceleration * leg.turn_axis;
  }
  if (heading_) lead(leg, since, &reference);
  reference.p_WD = X_WP_.p + X_WP_.R * reference.p_WD;
  for (Eigen::Vector3d* v :
       {&reference.v_WD, &reference.a_WD, &reference.n_WD, &reference.w_WD, &reference.alpha_WD,
        &reference.x_WD})
    *v = X_WP_.R * *v;
  return sample;
}

}  // namespace impedraw

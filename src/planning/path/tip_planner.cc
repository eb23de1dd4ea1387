#include "impedraw/planning/path/tip_planner.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

#include <fmt/core.h>
#include <Eigen/Geometry>

#include "impedraw/common/errors.h"
#include "impedraw/common/in_parallel.h"
#include "impedraw/common/range_check.h"
#include "impedraw/common/rotations.h"
#include "impedraw/planning/describe_path.h"
#include "impedraw/planning/path/stroke_fit.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
// largest share of the acceleration across the path; 0.6 remain along it
constexpr double kCentripetalShare = 0.8;
// share of the limits used; the rest covers maxima between the samples of PathSpline::bounds
constexpr double kMargin = 0.999;
constexpr double kClearance = 0.01;  // length of that clearing move along n [m]
constexpr double kPause = 0.1;       // rest where the run waits for a person [s]
constexpr double kStill = 1e-9;      // [m] or [rad]; shorter moves are skipped

// Appends legs. Each starts at rest where the previous one ended.
class Planner {
 public:
  Planner(const PathSettings& settings, const SpanLimits& limits)
      : s_(settings),
        limits_(limits),
        p_(settings.X_WP.R.transpose() * (settings.start_p_WE - settings.X_WP.p)),
        n_(settings.X_WP.R.transpose() * settings.start_n_W) {
    if (s_.vertical_pen) n_ = Vector3d::UnitZ();
    if (!s_.heading) return;
    x_ = settings.X_WP.R.transpose() * s_.heading->start_x_W;
    x_ = (x_ - n_ * n_.dot(x_)).normalized();
    p_ -= s_.heading->trail * x_;
  }

  TipPath plan(const std::vector<PlacedStroke>& placed, std::vector<FittedStroke> strokes,
               std::vector<ForceProfile> forces) {
    parts_.highest = s_.highest_z.value_or(highest(strokes));
    safe_z_ = parts_.highest + s_.safe_height;
    constexpr std::size_t kLegs = 9, kPoints = 7, kNormals = 5;  // of a stroke, at most, mostly
    parts_.legs.reserve(kLegs * strokes.size() + 1);
    parts_.points.reserve(kPoints * strokes.size() + 1);
    parts_.normals.reserve(kNormals * strokes.size() + 1);
    parts_.splines.reserve(strokes.size());
    parts_.below = -sunk();
    parts_.fixed_normals = s_.vertical_pen;
    parts_.approaches = {0.0, s_.approach_speed, s_.draw_acceleration};
    parts_.travels = {0.0, s_.travel_speed, s_.travel_acceleration};
    parts_.turns = {0.0, s_.turn_speed, s_.turn_acceleration};
    parts_.smoothing_time = s_.smoothing_time;
    parts_.heading = s_.heading;
    hold(s_.start_hold, Phase::travel);
    for (std::size_t i = 0; i < strokes.size(); ++i) {
      const Vector3d n = normal(strokes[i].first);
      const Vector3d first = strokes[i].first.p_P, hover = first + s_.hover_height * n;
      wait(placed[i]);
      lean_ = placed[i].lean_there;
      if (s_.heading && !strokes[i].parts.empty()) turn_on_the_way(strokes[i].parts.front(), n);
      travel_to(above(hover, n), hover, n);
      stroke_ = static_cast<int>(i);
      along_ = placed[i].start;
      approach(first - sunk());
      draw(strokes[i], placed[i].speed);
      n_ = normal(strokes[i].last);
      along_ = strokes[i].to;
      hold(s_.end_hold, Phase::draw);
      lean_ = placed[i].lean_off;
      lift();
    }
    std::vector<int> numbers;
    for (const PlacedStroke& stroke : placed) numbers.push_back(stroke.number);
    return TipPath(std::move(parts_), numbers, s_.X_WP, std::move(forces));
  }

 private:
  static Vector3d carried(const Vector3d& x, const Vector3d& from, const Vector3d& to) {
    return turn_between(from, to) * x;
  }

  // The turn about n that the heading x needs before the part.
  double spin_to(const PathSpline& part, const Vector3d& x) const {
    const SplinePoint first = part.at(0.0);
    const Vector3d wanted = turned_about(first.n, heading_at(first).t, s_.heading->yaw);
    const double shortest = std::atan2(first.n.dot(x.cross(wanted)), x.dot(wanted));
    const Turning turning = turning_of(part);
    double best = shortest, best_beyond = 1e9;
    for (const double by : {shortest, shortest - 2.0 * std::numbers::pi * (shortest > 0 ? 1 : -1),
                            shortest + 2.0 * std::numbers::pi * (shortest > 0 ? 1 : -1)}) {
      const double to = turned_ + by;
      const double beyond = std::max(
          {0.0, s_.heading->least - to - turning.least, to + turning.most - s_.heading->most});
      if (beyond < best_beyond - 1e-9) best = by, best_beyond = beyond;
    }
    return best;
  }

  // Sets the turn of the next move that travels, for a stroke that begins with the part.
  void turn_on_the_way(const PathSpline& part, const Vector3d& n) {
    Vector3d x = x_, from = n_;
    for (const Vector3d& to : {p_.z() < safe_z_ ? righted(n_) : n_, righted(n), n}) {
      x = carried(x, from, to);
      from = to;
    }
    spin_ = spin_to(part, x);
  }

  // At a corner, before the part.
  void turn_at_corner(const PathSpline& part) {
    const double spin = spin_to(part, x_);
    const Vector3d corner = p_;
    if (s_.heading->lifted) move(corner + s_.hover_height * n_, n_, Phase::lift);
    spin_ = spin;
    move(p_, n_, s_.heading->lifted ? Phase::travel : Phase::draw);
    if (s_.heading->lifted)
      approach(corner);
    else if (!parts_.legs.empty())
      parts_.legs.back().counts = true;
  }

  Vector3d normal(const SurfaceSample& sample) const {
    return s_.vertical_pen ? Vector3d(Vector3d::UnitZ()) : sample.n_P.normalized();
  }
  Vector3d sunk() const { return {0, 0, s_.sink}; }

  static double highest(const std::vector<FittedStroke>& strokes) {
    double z = -1e9;
    for (const FittedStroke& stroke : strokes) {
      z = std::max({z, stroke.first.p_P.z(), stroke.last.p_P.z()});
      for (const PathSpline& part : stroke.parts) {
        for (std::size_t i = 0; i < part.spans(); ++i)
          z = std::max(z, part.point(i, part.start(i)).z());
      }
    }
    return z;
  }

  // The point that the pen reaches from p along n: at the safe height or, on a steep place, just
  // clear of the surface. above() then leads straight up.
  Vector3d clear_of(const Vector3d& p, const Vector3d& n) const {
    const double rise = std::max(0.0, safe_z_ - p.z());
    return p + n * (n.z() >= std::cos(s_.steep) ? rise / n.z() : kClearance);
  }
  // n, or what is nearest to it and leans by lean_: the tool rights itself on the way.
  Vector3d righted(const Vector3d& n) const {
    if (n.z() >= std::cos(lean_)) return n;
    const double flat = n.head<2>().norm();
    if (flat < 1e-9) return Vector3d::UnitZ();
    const double s = std::sin(lean_) / flat;
    return {s * n.x(), s * n.y(), std::cos(lean_)};
  }
  Vector3d above(const Vector3d& p, const Vector3d& n) const {
    Vector3d q = clear_of(p, n);
    q.z() = std::max(q.z(), safe_z_);
    return q;
  }

  // The place of x in `all`, whose last it is or becomes.
  static int last_of(std::vector<Vector3d>* all, const Vector3d& x) {
    if (all->empty() || all->back() != x) all->push_back(x);
    return static_cast<int>(all->size()) - 1;
  }

  PathLeg& add(Phase phase) {
    PathLeg& leg = parts_.legs.emplace_back();
    leg.start = parts_.duration;
    leg.phase = phase;
    leg.stroke = stroke_;
    leg.along = along_;
    leg.place = last_of(&parts_.points, p_);
    leg.normal = last_of(&parts_.normals, n_);
    if (s_.heading) parts_.spins.push_back({.x = x_});
    return leg;
  }

  // Moves straight to q while the normal turns to `n`; no sooner than it turns, if `evenly`.
  void move(const Vector3d& q, const Vector3d& n, Phase phase, bool evenly = false) {
    const PathMove way = move_between(
                       p_, q, phase == Phase::approach ? parts_.approaches : parts_.travels),
                   turn = turn_between(n_, n, parts_.turns);
    const bool moves = way.progress.length >= kStill, turns = turn.progress.length >= kStill;
    const double spin = phase == Phase::lift || phase == Phase::approach || std::abs(spin_) < kStill
                            ? 0.0
                            : std::exchange(spin_, 0.0);
    if (!moves && !turns && spin == 0.0) return;
    PathLeg& leg = add(phase);
    leg.moves = moves;
    leg.turns = turns;
    if (moves) last_of(&parts_.points, q);
    if (turns) last_of(&parts_.normals, n);
    const double moving = moves ? rest_to_rest_duration(way.progress, s_.smoothing_time) : 0.0,
                 turning = turns ? rest_to_rest_duration(turn.progress, s_.smoothing_time) : 0.0;
    leg.evenly = evenly && moves && turning > moving;
    double duration = std::max(moving, turning);  // [s]
    if (spin != 0.0) {
      PathSpin& turned = parts_.spins.back();
      turned.progress = {std::abs(spin), s_.turn_speed, s_.turn_acceleration};
      turned.back = spin < 0.0;
      turned_ += spin;
      duration = std::max(duration, rest_to_rest_duration(turned.progress, s_.smoothing_time));
    }
    if (s_.heading) {
      const Vector3d axis = turns ? turn.direction : Vector3d::UnitX();
      x_ = turned_about(n, Eigen::AngleAxisd(turn.progress.length, axis) * x_, spin);
    }
    parts_.duration += duration;
    p_ = q;
    n_ = n;
  }

  void hold(double duration, Phase phase, bool counts = false) {
    if (!(duration > 0)) return;
    add(phase).counts = counts;
    parts_.duration += duration;
  }

  void wait(const PlacedStroke& stroke) {
    if (stroke.pause) parts_.pauses.push_back(parts_.duration);
    hold(std::max(stroke.wait, stroke.pause ? kPause : 0.0), Phase::travel);
  }

  void travel_to(const Vector3d& above_hover, const Vector3d& hover, const Vector3d& n) {
    if (p_.z() < safe_z_) move({p_.x(), p_.y(), safe_z_}, righted(n_), Phase::travel);
    move(above_hover, righted(n), Phase::travel);
    // Near the surface it leans only as far as the height lets a pad's rim do.
    move(clear_of(hover, n), righted(n), Phase::travel);
    move(hover, n, Phase::travel, true);
  }

  void approach(const Vector3d& first) {
    move(first, n_, Phase::approach);
    hold(s_.settle_time, Phase::approach);
  }

  void draw(FittedStroke& stroke, double speed) {
    if (stroke.parts.empty()) hold(s_.dot_time, Phase::draw, true);
    for (PathSpline& part : stroke.parts) {
      if (s_.heading && &part != &stroke.parts.front()) turn_at_corner(part);
      PathLeg& leg = add(Phase::draw);
      leg.counts = leg.splined = true;
      leg.place = static_cast<int>(parts_.splines.size());
      const SplinePoint last = part.at(part.length());
      p_ = last.p - sunk();
      along_ = last.along;
      if (s_.heading) {
        n_ = last.n;
        x_ = turned_about(n_, heading_at(last).t, s_.heading->yaw);
        turned_ += turning_of(part).total;
      }
      SpeedProfile progress = drawing_profile(part, speed > 0.0 ? speed : s_.draw_speed);
      parts_.duration += progress.duration();
      parts_.splines.push_back({std::move(part), std::move(progress)});
    }
  }

  // The largest |d²p/du²| and |dp/du · d²p/du²| seen along the drawing axis, sampled.
  static std::pair<double, double> sway(const PathSpline& part, std::size_t span) {
    double bend = 0.0, stretch = 0.0;
    for (int k = 0; k <= 4; ++k) {
      const SplinePoint s = part.at(part.start(span) + (part.end(span) - part.start(span)) * k / 4);
      bend = std::max(bend, s.ddp.head<2>().norm());
      stretch = std::max(stretch, std::abs(s.dp.head<2>().dot(s.ddp.head<2>())));
    }
    return {bend, stretch};
  }

  SpeedProfile drawing_profile(const PathSpline& part, double speed) const {
    const double A = kMargin * s_.draw_acceleration;
    std::vector<SpeedSpan> spans;
    spans.reserve(part.spans());
    for (std::size_t i = 0; i < part.spans(); ++i) {
      auto [slope, bend, stretch, rise, turn, turn_bend] = part.bounds(i);
      // Across the surface, normal_acceleration is the limit.
      if (!s_.vertical_pen) std::tie(bend, stretch) = sway(part, i);
      double v = std::min(kMargin * speed / slope,
                          bend > 0 ? std::sqrt(kCentripetalShare * A / bend) : 1e9);
      if (!s_.vertical_pen) {
        if (rise > 0) v = std::min(v, std::sqrt(s_.normal_acceleration / rise));
        // |u̇² n'' + ü n'| ≤ A_tilt, kCentripetalShare of it for the first term
        if (turn > 0) v = std::min(v, kMargin * s_.tilt_speed / turn);
        if (turn_bend > 0)
          v = std::min(v, std::sqrt(kCentripetalShare * s_.tilt_acceleration / turn_bend));
      }
      // |u̇² p'' + ü p'|² ≤ (bend v²)² + 2 stretch v² ü + (slope ü)² = A²
      const double c = bend * v * v, half = stretch * v * v;
      const double a =
          (std::sqrt(half * half + slope * slope * (A * A - c * c)) - half) / (slope * slope);
      const double tilt =
          turn > 0 && !s_.vertical_pen ? (s_.tilt_acceleration - turn_bend * v * v) / turn : 1e9;
      spans.push_back({part.end(i) - part.start(i), v, std::min(a, tilt)});
      if (s_.heading) keep_turn_speed(part, i, &spans.back());
    }
    if (limits_) limits_(part, &spans);
    return SpeedProfile(std::move(spans), s_.smoothing_time);
  }

  // |dψ/du| u̇ ≤ turn_speed,  |d²ψ/du² u̇² + dψ/du ü| ≤ turn_acceleration
  void keep_turn_speed(const PathSpline& part, std::size_t span, SpeedSpan* limit) const {
    constexpr int kLooks = 4;
    const double from = part.start(span), du = (part.end(span) - from) / kLooks;
    double turn = 0.0, bend = 0.0, before = 0.0;
    for (int k = 0; k <= kLooks; ++k) {
      const double here = heading_at(part.at(from + k * du)).turn;
      turn = std::max(turn, std::abs(here));
      if (k > 0) bend = std::max(bend, std::abs(here - before) / du);
      before = here;
    }
    if (turn > 0.0) limit->speed = std::min(limit->speed, s_.turn_speed / turn);
    if (bend > 0.0)
      limit->speed =
          std::min(limit->speed, std::sqrt(kCentripetalShare * s_.turn_acceleration / bend));
    const double left = s_.turn_acceleration - bend * limit->speed * limit->speed;
    if (turn > 0.0) limit->acceleration = std::min(limit->acceleration, left / turn);
  }

  void lift() {
    const Vector3d out = clear_of(p_, n_), n = righted(n_);
    move(out, n, Phase::lift, true);
    move({out.x(), out.y(), std::max(out.z(), safe_z_)}, n, Phase::lift);
  }

  const PathSettings& s_;
  const SpanLimits& limits_;
  double safe_z_ = 0;
  double lean_ = PlacedStroke::kWayLean;
  int stroke_ = -1;     // at hand, in the order of the path
  double along_ = 0.0;  // where the pen is on its stroke [m]
  Vector3d p_, n_;
  Vector3d x_ = Vector3d::Zero();  // led heading
  double turned_ = 0.0;            // about n, since t = 0 [rad]
  double spin_ = 0.0;              // that the next move turns the tool by, on its way [rad]
  PathParts parts_;
};

}  // namespace

void validate(const PathSettings& s) {
  require_ranges("path", s);
  require_in_range("path.knot_spacing", s.knot_spacing, Range::positive(), "m");
  require_in_range("path.sink", s.sink, Range::at_least(0.0), "m");
  if (s.highest_z) require_in_range("path.highest_z", *s.highest_z, Range::any(), "m");
  for (const double x : s.start_p_WE) require_in_range("path.start_p_WE", x, Range::any(), "m");
  require_in_range("path.start_n_W length", s.start_n_W.norm(), {1 - 1e-6, 1 + 1e-6}, "");
}

TipPath plan_tip_path(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& surface,
                      const PathSettings& settings, const SpanLimits& limits) {
  validate(settings);
  if (strokes.empty()) throw InputError("path: there are no strokes to plan");
  constexpr double kDegree = std::numbers::pi / 180;
  const FitSettings fit{
      settings.tolerance,
      settings.rounding,
      settings.knot_spacing,
      settings.corner_angle_deg * kDegree,
      settings.normal_smoothing,
      {settings.tilt_allowance_deg * kDegree, kMargin * settings.tilt_speed / settings.draw_speed,
       kCentripetalShare * settings.tilt_acceleration /
           (settings.draw_speed * settings.draw_speed)},
      settings.lean_deg};
  std::vector<FittedStroke> fitted(strokes.size());
  const bool pressed = std::ranges::any_of(
      strokes, [](const PlacedStroke& stroke) { return !stroke.force.empty(); });
  std::vector<ForceProfile> forces(pressed ? strokes.size() : 0);
  in_parallel(static_cast<int>(strokes.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    fitted[k] = fit_stroke(strokes[k], surface, fit);
    if (pressed) forces[k] = ForceProfile(strokes[k], settings.force_rate / settings.draw_speed);
  });
  return Planner(settings, limits).plan(strokes, std::move(fitted), std::move(forces));
}

}  // namespace impedraw

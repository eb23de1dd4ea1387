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
#include "impedraw/planning/describe_path.h"
#include "impedraw/planning/path/stroke_fit.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
// largest share of the acceleration across the path; 0.6 remain along it
constexpr double kCentripetalShare = 0.8;
// share of the limits used; the rest covers maxima between the samples of PathSpline::bounds
constexpr double kMargin = 0.999;
// Between strokes the pen leans off the drawing axis by no more than this, so that the arm reaches
// far over steep surfaces. From a steeper place a lift goes straight up after clearing the surface,
// and the pen rights itself on the way [rad].
constexpr double kLeaning = 35.0 * std::numbers::pi / 180.0;
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

  TipPath plan(std::vector<FittedStroke> strokes) {
    safe_z_ = s_.highest_z.value_or(highest(strokes)) + s_.safe_height;
    constexpr std::size_t kLegs = 9, kMoves = 7, kTurns = 3;  // of a stroke, at most, mostly
    parts_.legs.reserve(kLegs * strokes.size() + 1);
    parts_.moves.reserve(kMoves * strokes.size());
    parts_.turns.reserve(kTurns * strokes.size());
    parts_.splines.reserve(strokes.size());
    parts_.smoothing_time = s_.smoothing_time;
    parts_.heading = s_.heading;
    hold(s_.start_hold, Phase::travel, -1, false);
    for (std::size_t i = 0; i < strokes.size(); ++i) {
      const Vector3d n = normal(strokes[i].first);
      const Vector3d first = strokes[i].first.p_P, hover = first + s_.hover_height * n;
      wait(strokes[i]);
      if (s_.heading && !strokes[i].parts.empty()) turn_on_the_way(strokes[i].parts.front(), n);
      travel_to(above(hover, n), hover, n);
      pressed_ = strokes[i].force.empty() ? -1 : static_cast<int>(i);
      along_ = strokes[i].from;
      approach(first - sunk());
      draw(strokes[i], static_cast<int>(i));
      n_ = normal(strokes[i].last);
      along_ = strokes[i].to;
      hold(s_.end_hold, Phase::draw, -1, true);
      lift();
    }
    std::vector<int> numbers;
    std::vector<ForceProfile> forces;
    const bool any_force = std::ranges::any_of(
        strokes, [](const FittedStroke& stroke) { return !stroke.force.empty(); });
    for (FittedStroke& stroke : strokes) {
      numbers.push_back(stroke.number);
      if (any_force) forces.push_back(std::move(stroke.force));
    }
    return TipPath(std::move(parts_), numbers, s_.X_WP, std::move(forces));
  }

 private:
  static Vector3d carried(const Vector3d& x, const Vector3d& from, const Vector3d& to) {
    return Eigen::Quaterniond::FromTwoVectors(from, to) * x;
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
  void turn_at_corner(const PathSpline& part, int index) {
    const double spin = spin_to(part, x_);
    const Vector3d corner = p_;
    if (s_.heading->lifted)
      move(corner + s_.hover_height * n_, n_, Phase::lift, s_.travel_speed, s_.travel_acceleration);
    spin_ = spin;
    move(p_, n_, s_.heading->lifted ? Phase::travel : Phase::draw, 1.0, 1.0, !s_.heading->lifted);
    if (s_.heading->lifted)
      approach(corner);
    else if (!parts_.legs.empty())
      parts_.legs.back().stroke = index;
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

  // The point that the pen reaches from p along n: at the safe height or, where n is too flat, just
  // clear of the surface. above() then leads straight up.
  Vector3d clear_of(const Vector3d& p, const Vector3d& n) const {
    const double rise = std::max(0.0, safe_z_ - p.z());
    return p + n * (n.z() >= std::cos(kLeaning) ? rise / n.z() : kClearance);
  }
  // n, or what is nearest to it and leans by kLeaning.
  static Vector3d righted(const Vector3d& n) {
    if (n.z() >= std::cos(kLeaning)) return n;
    const double flat = n.head<2>().norm();
    if (flat < 1e-9) return Vector3d::UnitZ();
    const double s = std::sin(kLeaning) / flat;
    return {s * n.x(), s * n.y(), std::cos(kLeaning)};
  }
  Vector3d above(const Vector3d& p, const Vector3d& n) const {
    Vector3d q = clear_of(p, n);
    q.z() = std::max(q.z(), safe_z_);
    return q;
  }

  PathLeg& add(Phase phase, bool pen_down) {
    PathLeg& leg = parts_.legs.emplace_back();
    leg.start = parts_.duration;
    leg.phase = phase;
    leg.pen_down = pen_down;
    leg.pressed = pen_down ? pressed_ : -1;
    leg.along = along_;
    leg.p = p_;
    if (parts_.normals.empty() || parts_.normals.back() != n_) parts_.normals.push_back(n_);
    leg.normal = static_cast<int>(parts_.normals.size()) - 1;
    if (s_.heading) {
      leg.spin = static_cast<int>(parts_.spins.size());
      parts_.spins.push_back({.x = x_});
    }
    return leg;
  }

  // Moves straight to q while the normal turns to `n`.
  void move(const Vector3d& q, const Vector3d& n, Phase phase, double speed, double acceleration,
            bool pen_down = false) {
    const Vector3d way = q - p_;
    const Vector3d across = n_.cross(n);
    const double angle = std::atan2(across.norm(), n_.dot(n));
    const double spin = phase == Phase::lift || phase == Phase::approach || std::abs(spin_) < kStill
                            ? 0.0
                            : std::exchange(spin_, 0.0);
    if (way.norm() < kStill && angle < kStill && spin == 0.0) return;
    PathLeg& leg = add(phase, pen_down);
    double duration = 0.0;  // [s]
    if (way.norm() >= kStill) {
      leg.move = static_cast<int>(parts_.moves.size());
      parts_.moves.push_back({way.normalized(), {way.norm(), speed, acceleration}});
      duration = rest_to_rest_duration(parts_.moves.back().progress, s_.smoothing_time);
    }
    Vector3d axis = Vector3d::UnitX();
    if (angle >= kStill) {
      axis = across.norm() > 1e-9 ? across.normalized() : n_.unitOrthogonal();
      leg.turn = static_cast<int>(parts_.turns.size());
      parts_.turns.push_back({axis, {angle, s_.turn_speed, s_.turn_acceleration}});
      duration = std::max(duration,
                          rest_to_rest_duration(parts_.turns.back().progress, s_.smoothing_time));
    }
    if (spin != 0.0) {
      PathSpin& turned = parts_.spins[leg.spin];
      turned.progress = {std::abs(spin), s_.turn_speed, s_.turn_acceleration};
      turned.back = spin < 0.0;
      turned_ += spin;
      duration = std::max(duration, rest_to_rest_duration(turned.progress, s_.smoothing_time));
    }
    if (s_.heading) x_ = turned_about(n, Eigen::AngleAxisd(angle, axis) * x_, spin);
    parts_.duration += duration;
    p_ = q;
    n_ = n;
  }

  void hold(double duration, Phase phase, int stroke, bool pen_down) {
    if (!(duration > 0)) return;
    PathLeg& leg = add(phase, pen_down);
    leg.stroke = stroke;
    parts_.duration += duration;
  }

  void wait(const FittedStroke& stroke) {
    const double least = stroke.pause ? kPause : 0.0;
    if (!(std::max(stroke.wait, least) > 0.0)) return;
    hold(std::max(stroke.wait, least), Phase::travel, -1, false);
    parts_.legs.back().pause = stroke.pause;
  }

  void travel_to(const Vector3d& above_hover, const Vector3d& hover, const Vector3d& n) {
    const double v = s_.travel_speed, a = s_.travel_acceleration;
    if (p_.z() < safe_z_) move({p_.x(), p_.y(), safe_z_}, righted(n_), Phase::travel, v, a);
    move(above_hover, righted(n), Phase::travel, v, a);
    move(clear_of(hover, n), n, Phase::travel, v, a);
    move(hover, n, Phase::travel, v, a);
  }

  void approach(const Vector3d& first) {
    move(first, n_, Phase::approach, s_.approach_speed, s_.draw_acceleration, true);
    hold(s_.settle_time, Phase::approach, -1, true);
  }

  void draw(FittedStroke& stroke, int index) {
    if (stroke.parts.empty()) hold(s_.dot_time, Phase::draw, index, true);
    for (PathSpline& part : stroke.parts) {
      if (s_.heading && &part != &stroke.parts.front()) turn_at_corner(part, index);
      PathLeg& leg = add(Phase::draw, true);
      leg.stroke = index;
      leg.p = -sunk();
      leg.spline = static_cast<int>(parts_.splines.size());
      leg.fixed_normal = s_.vertical_pen;
      const SplinePoint last = part.at(part.length());
      p_ = last.p - sunk();
      along_ = last.along;
      if (s_.heading) {
        n_ = last.n;
        x_ = turned_about(n_, heading_at(last).t, s_.heading->yaw);
        turned_ += turning_of(part).total;
      }
      SpeedProfile progress =
          drawing_profile(part, stroke.speed > 0.0 ? stroke.speed : s_.draw_speed);
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
    const Vector3d out = clear_of(p_, n_);
    move(out, n_, Phase::lift, s_.travel_speed, s_.travel_acceleration);
    move({out.x(), out.y(), std::max(out.z(), safe_z_)}, righted(n_), Phase::lift, s_.travel_speed,
         s_.travel_acceleration);
  }

  const PathSettings& s_;
  const SpanLimits& limits_;
  double safe_z_ = 0;
  int pressed_ = -1;    // stroke whose force the pen has
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
           (settings.draw_speed * settings.draw_speed)}};
  std::vector<FittedStroke> fitted(strokes.size());
  in_parallel(static_cast<int>(strokes.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    const PlacedStroke& stroke = strokes[k];
    fitted[k] = fit_stroke(stroke, surface, fit);
    fitted[k].force = ForceProfile(stroke, settings.force_rate / settings.draw_speed);
    fitted[k].speed = stroke.speed;
    fitted[k].wait = stroke.wait;
    fitted[k].pause = stroke.pause;
  });
  return Planner(settings, limits).plan(std::move(fitted));
}

}  // namespace impedraw

#include "impedraw/simulation/canvas_motion.h"

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/simulation/describe_world.h"

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr int kJoltWaves = 40;  // of each axis; the noise repeats after minutes

// Rises from 0 to 1 while x does, with two continuous derivatives.
struct Rise {
  double value, slope, area;  // area: ∫ value
};

Rise rise(double x) {
  if (x <= 0.0) return {0.0, 0.0, 0.0};
  if (x >= 1.0) return {1.0, 0.0, 0.5 + (x - 1.0)};
  const double x2 = x * x, x3 = x2 * x;
  return {x3 * (10.0 - 15.0 * x + 6.0 * x2), 30.0 * x2 * (1.0 - x) * (1.0 - x),
          x2 * x2 * (2.5 - 3.0 * x + x2)};
}

Vector3d direction(const Vector3d& axis, const char* name) {
  if (!axis.allFinite() || !(axis.norm() > 0.0))
    throw InputError(std::string("canvas.motion.") + name + " is no direction");
  return axis.normalized();
}

}  // namespace

CanvasMotion::CanvasMotion(const CanvasMotionSettings& settings) : settings_(settings) {
  CanvasMotionSettings& s = settings_;
  require_ranges("canvas.motion", s);
  if (s.stop && !(*s.stop >= s.start + s.ramp))
    throw InputError("canvas.motion.stop must be at least ramp after start");
  s.turn_axis = direction(s.turn_axis, "turn_axis");
  s.roll_axis = direction(s.roll_axis, "roll_axis");
  moves_ = !s.velocity.isZero(0.0) || s.turn_speed != 0.0 || !s.sway.isZero(0.0) || s.roll != 0.0 ||
           s.jolts > 0.0;
  if (!s.file.empty()) {
    if (moves_)
      throw InputError(
          "canvas.motion.file: a recorded motion stands alone; valid beside it are start, stop and "
          "ramp");
    recorded_ = std::make_shared<RecordedMotion>(read_recorded_motion(s.file));
    const double end = s.start + recorded_->duration();
    if (recorded_->duration() < s.ramp)
      throw InputError(fmt::format("canvas.motion.ramp: {} s; the record lasts {:.3g} s", s.ramp,
                                   recorded_->duration()));
    if (s.stop && *s.stop > end)
      throw InputError(
          fmt::format("canvas.motion.stop: {} s; the record ends at {:.6g} s", *s.stop, end));
    if (!s.stop) s.stop = end;
    moves_ = true;
  }
  if (s.jolts <= 0.0) return;
  // Waves of equal power, one in each of kJoltWaves bands.
  std::mt19937_64 random(s.seed);
  const auto uniform = [&] { return std::ldexp(static_cast<double>(random() >> 11), -53); };
  const double amplitude = s.jolts * std::sqrt(2.0 / kJoltWaves);
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = 0; k < kJoltWaves; ++k) {
      const double f = (k + uniform()) / kJoltWaves * s.jolt_bandwidth;
      const double phase = 2.0 * std::numbers::pi * uniform();
      jolts_.push_back({amplitude * Vector3d::Unit(axis), 2.0 * std::numbers::pi * f, phase});
    }
  }
}

CanvasMotion::State CanvasMotion::recorded_at(double t) const noexcept {
  const CanvasMotionSettings& s = settings_;
  const Rise begin = rise((t - s.start) / s.ramp), end = rise((t - *s.stop) / s.ramp);
  const double rate = begin.value - end.value;
  const RecordedMotion::State body = recorded_->at(s.ramp * (begin.area - end.area));
  State state;
  state.X_WK = body.X;
  state.w = rate * body.w;
  state.centre = body.X * s.centre;
  state.v = rate * (body.v + body.w.cross(state.centre - body.p));
  return state;
}

CanvasMotion::State CanvasMotion::at(double t) const noexcept {
  if (recorded_) return recorded_at(t);
  const CanvasMotionSettings& s = settings_;
  const double since = t - s.start;
  const Rise begin = rise(since / s.ramp),
             end = s.stop ? rise((t - *s.stop) / s.ramp) : Rise{0.0, 0.0, 0.0};

  // u and its rate; both ramps have the same length
  const double u = s.ramp * (begin.area - end.area), u_rate = begin.value - end.value;
  Vector3d d = u * s.velocity, v = u_rate * s.velocity;

  // g(t) f(t) with the gain g of the ramps
  const double gain = begin.value - end.value, gain_rate = (begin.slope - end.slope) / s.ramp;
  const auto wave = [&](double rate, double phase) {
    const double f = std::sin(rate * since + phase), f_rate = rate * std::cos(rate * since + phase);
    return Eigen::Vector2d(gain * f, gain * f_rate + gain_rate * f);
  };
  const Eigen::Vector2d sway = wave(2.0 * std::numbers::pi * s.sway_frequency, 0.0);
  d += sway[0] * s.sway;
  v += sway[1] * s.sway;
  for (const Wave& jolt : jolts_) {
    const Eigen::Vector2d now = wave(jolt.rate, jolt.phase);
    d += now[0] * jolt.amplitude;
    v += now[1] * jolt.amplitude;
  }

  const Eigen::Vector2d roll = wave(2.0 * std::numbers::pi * s.roll_frequency, 0.0);
  const Eigen::Matrix3d turned =
      Eigen::AngleAxisd(s.turn_speed * u, s.turn_axis).toRotationMatrix();
  State state;
  state.X_WK.R = turned * Eigen::AngleAxisd(s.roll * roll[0], s.roll_axis).toRotationMatrix();
  state.centre = s.centre + d;
  state.X_WK.p = state.centre - state.X_WK.R * s.centre;
  state.v = v;
  state.w = s.turn_speed * u_rate * s.turn_axis + s.roll * roll[1] * (turned * s.roll_axis);
  return state;
}

}  // namespace impedraw

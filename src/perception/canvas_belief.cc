#include "impedraw/perception/canvas_belief.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "impedraw/common/rotations.h"
#include "impedraw/perception/rotation_coordinates.h"

namespace impedraw {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kLatenessTime = 1.0;  // over which it is averaged [s]
// A belief that is off by kFar is smoothed twice as fast, and at most kMostHaste times.
constexpr double kFar = 0.5e-3, kMostHaste = 4.0;  // [m]
constexpr double kTurnLever = 0.15;                // at which a turn counts [m]
// After so long without a frame the canvas is taken to stand where it was foreseen [s]: beyond that
// a forecast would lead the pen anywhere.
constexpr double kForeseen = 3.0;

}  // namespace

const std::array<AxisModel, CanvasBelief::kFilters> CanvasBelief::kBank = {{{1, 1e-10},
                                                                            {2, 1e-9},
                                                                            {2, 1e-5},
                                                                            {3, 1e-3},
                                                                            {3, 0.1},  //
                                                                            {2, 1e-4, 3.0},
                                                                            {2, 1e-3, 3.0},
                                                                            {2, 1e-2, 3.0},
                                                                            {2, 1e-1, 3.0},
                                                                            {3, 1e-2, 8.0},
                                                                            {3, 1e-1, 8.0},
                                                                            {3, 1.0, 8.0},
                                                                            {3, 10.0, 8.0}}};
const std::array<double, CanvasBelief::kBands> CanvasBelief::kCutoffs = {0.7, 1.1, 1.8, 3.0};

AxisState CanvasBelief::model_state(const Entry& from, int model, int axis,
                                    double time) const noexcept {
  if (model < kFilters)
    return from.filters[model][axis].ahead(time - from.time, kBank[model].rate, kBank[model].order);
  if (model < kSwinging) return from.polynomials[model - kFilters][axis].at(time);
  return from.waves[axis].at(time);
}

bool CanvasBelief::holds(const Entry& entry, int model, int axis) const noexcept {
  if (model < kFilters) return true;
  if (model == kSwinging) return entry.waves[axis].fitted;
  return entry.fitted[axis] &&
         (model < kRepeated || std::isfinite(entry.polynomials[kBands][axis].c[0]));
}

std::array<double, CanvasBelief::kModels> CanvasBelief::weights(const Entry& from,
                                                                int axis) const noexcept {
  // All errors hold the noise of what they are compared with: what one has beyond the best counts.
  // The simpler of two models that do as well is to be preferred.
  constexpr double kAlike = 0.03;  // in shares of that noise
  const Score& score = scores[axis];
  const auto has = [&](int m) {
    return holds(from, m, axis) && (score.weight > 0.0 || m < kFilters);
  };
  double best = 1e300;
  for (int m = 0; m < kModels; ++m)
    if (has(m)) best = std::min(best, score.square[m]);
  const double alike = kAlike * score.noise;
  std::array<double, kModels> w{};
  double sum = 0.0;
  for (int m = 0; m < kModels; ++m) {
    if (!has(m)) continue;
    const double beyond = 1.0 + (score.square[m] - best) / (alike + 1e-14);
    const double simple = m < kPlain ? std::pow(0.3, m) : m < kSwinging ? 1e-2 : 0.1;
    w[m] = simple / (beyond * beyond * beyond);
    sum += w[m];
  }
  for (double& share : w) share /= sum;
  return w;
}

AxisState CanvasBelief::blend(const Entry& from, int axis, double time) const noexcept {
  const std::array<double, kModels> w = weights(from, axis);
  AxisState out;
  for (int m = 0; m < kModels; ++m) {
    if (w[m] == 0.0) continue;
    const AxisState s = model_state(from, m, axis, time);
    out.x += w[m] * s.x;
    out.v += w[m] * s.v;
    out.a += w[m] * s.a;
  }
  return out;
}

CanvasEstimate CanvasBelief::estimate(const std::array<AxisState, kAxes>& s, double time,
                                      double lateness, double unfelt) const noexcept {
  CanvasEstimate out;
  out.age = time - last.time;
  const auto of = [&s](int first, double AxisState::*member) {
    return Vector3d(s[first].*member, s[first + 1].*member, s[first + 2].*member);
  };
  const Vector3d c = of(0, &AxisState::x), c_v = of(0, &AxisState::v), c_a = of(0, &AxisState::a);
  const Vector3d phi = of(3, &AxisState::x), rate = of(3, &AxisState::v),
                 rise = of(3, &AxisState::a);
  FrameMotion& m = out.motion;
  m.X_WK.R = rotation(phi) * R_0;
  m.w = rate_map(phi) * rate;
  constexpr double h = 1e-4;  // [s]
  m.alpha = (rate_map(phi + h * rate) * (rate + h * rise) -
             rate_map(phi - h * rate) * (rate - h * rise)) /
            (2.0 * h);
  const Vector3d r = -(m.X_WK.R * centre_K);  // from the centre to K's origin
  m.X_WK.p = c + r;
  m.v = c_v + m.w.cross(r);
  m.a = c_a + m.alpha.cross(r) + m.w.cross(m.w.cross(r));
  out.centre_W = c;

  // The error after one lateness grows with its square, as an unforeseen acceleration's effect.
  const double growth = std::max(1.0, out.age / lateness);
  double position = 0.0;
  for (int i = 0; i < kAxes; ++i) {
    const double variance = last.filters[2][i].P[0];
    const double off = (i < 3 ? unfelt : 1.0) * std::max(0.0, scores[i].blended - scores[i].noise);
    const double square = variance + off * std::pow(growth, 4);
    out.covariance(i < 3 ? 3 + i : i - 3, i < 3 ? 3 + i : i - 3) = square;
    if (i < 3) position += square;
  }
  const bool old = out.age > longest_age;
  const bool unsure = std::sqrt(position) > largest_error;
  out.status = old || unsure ? CanvasStatus::stale
               : open > 0    ? CanvasStatus::undetermined
                             : CanvasStatus::ok;
  return out;
}

CanvasEstimate CanvasBelief::predict(double time, double lateness) const noexcept {
  if (!known) return {};
  std::array<AxisState, kAxes> s;
  for (int i = 0; i < kAxes; ++i) s[i] = blend(last, i, time);
  return estimate(s, time, lateness);
}

std::string CanvasBelief::open_text() const {
  std::string text;
  for (int k = 0; k < open; ++k)
    text += (k == 0 ? "" : ", or ") + open_directions[static_cast<std::size_t>(k)].text();
  return text;
}

// φ of another R_0, and its rate.
void SmoothedCanvas::refer_to(const Matrix3d& R_0) noexcept {
  const Vector3d phi_0(smooth_[3].x, smooth_[4].x, smooth_[5].x);
  const Matrix3d R = rotation(phi_0) * R_0_;
  const Vector3d w = rate_map(phi_0) * Vector3d(smooth_[3].v, smooth_[4].v, smooth_[5].v);
  R_0_ = R_0;
  const Vector3d phi = rotation_vector(R * R_0_.transpose()), rate = rate_map(phi).inverse() * w;
  for (int i = 0; i < 3; ++i) smooth_[3 + i] = {phi[i], rate[i], 0.0};
}

CanvasEstimate SmoothedCanvas::follow(const CanvasBelief& belief, double time,
                                      const CanvasShift& felt) noexcept {
  if (!belief.known) return {};
  const double dt = time - time_, shown = belief.last.time;
  const bool anew = time_ < 0.0 || !(dt >= 0.0) || dt > 0.1;
  if (belief.R_0 != R_0_) refer_to(belief.R_0);
  const double ahead = std::min(time, shown + kForeseen);
  if (!anew) lateness_ += dt / kLatenessTime * (std::clamp(time - shown, 0.01, 0.3) - lateness_);
  for (int i = 0; i < CanvasBelief::kAxes; ++i) {
    AxisState target = belief.blend(belief.last, i, belief.prediction ? ahead : shown);
    if (time > ahead) target.v = target.a = 0.0;
    AxisState& s = smooth_[i];
    if (i < 3) {
      target.x += felt.d[i];
      s.x += dt * felt.v[i];
    }
    if (anew) {
      s = target;
      continue;
    }
    // To the present first, so that like is compared with like; else it would run a step ahead.
    s.x += dt * (s.v + 0.5 * dt * target.a);
    s.v += dt * target.a;
    const double off = std::abs(target.x - s.x) / (i < 3 ? kFar : kFar / kTurnLever);
    const double rate = kSmoothing * std::min(kMostHaste, 1.0 + off);
    const double correction = rate * rate * (target.x - s.x) + 2.0 * rate * (target.v - s.v);
    s.x += 0.5 * dt * dt * correction;
    s.v += dt * correction;
    // The corrections are the estimate's motion, not the canvas's: they are not fed forward.
    s.a += std::min(1.0, kSmoothing * dt) * (target.a - s.a);
  }
  time_ = time;
  std::array<AxisState, CanvasBelief::kAxes> now = smooth_;
  for (int i = 0; i < 3; ++i) now[i].v += felt.across[i];
  return belief.estimate(now, time, lateness_, felt.unfelt);
}

}  // namespace impedraw

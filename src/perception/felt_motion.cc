#include "impedraw/perception/felt_motion.h"

#include <algorithm>
#include <cmath>

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr double kFeltScoreTime = 1.0;  // [s]
constexpr double kLeastPress = 0.5;     // along n, below which nothing is felt [N]
constexpr double kLeastFriction = 0.1;  // f_t against f_n, below which it tells no direction
constexpr double kRateFilter = 60.0;    // of the velocities [1/s]
constexpr double kFurthest = 0.03;      // of a shift [m]
constexpr std::size_t kStride = 8;      // steps from one evaluation of the forecast to the next

constexpr double kFirstError = 0.2e-3;  // of what is felt, before frames tell [m]
constexpr double kResolved = 0.1e-3;    // least σ: feeling is no better than that [m]
constexpr double kSurely = 1.5;  // mean square off against a frame's noise, of a right forecast

FrameMotion forecast(const CanvasBelief& belief, double time) noexcept {
  return belief.predict(time, 0.06).motion;
}

// Variance of where a frame shows the point p_W to be, along `axis`.
double noise_at(const CanvasBelief& belief, const Vector3d& p_W, const Vector3d& axis) noexcept {
  const auto& v = belief.last.variance;
  const Vector3d turn = (p_W - belief.last.X_WK * belief.centre_K).cross(axis);
  return axis.cwiseAbs2().dot(Vector3d(v[0], v[1], v[2])) +
         turn.cwiseAbs2().dot(Vector3d(v[3], v[4], v[5]));
}

}  // namespace

FeltMotion::FeltMotion() : steps_(kMost) {
  share_.fill(0.0);
  d_.fill(Vector3d::Zero());
  rate_.fill(Vector3d::Zero());
}

// Until frames tell, the forecast is off as it was lately, and what is felt by kFirstError.
void FeltMotion::expect(const CanvasBelief& belief) noexcept {
  for (int k = 0; k < kDirections; ++k) {
    Score& s = scores_[k];
    const Vector3d& axis = step(0).axes[k];
    if (s.begun || axis.isZero(0.0)) continue;
    s.begun = true;
    double noise = 0.0;
    for (int i = 0; i < 3; ++i) {
      s.without += axis[i] * axis[i] * belief.scores[i].blended;
      noise += axis[i] * axis[i] * belief.scores[i].noise;
    }
    s.with = noise + kFirstError * kFirstError;
    weigh(k, noise);
  }
}

void FeltMotion::weigh(int k, double noise) noexcept {
  const Score& s = scores_[k];
  noise = std::max(noise, kResolved * kResolved);
  const double E_F = std::max(0.0, s.without - kSurely * noise),
               E_d = std::max(noise, s.with - noise);
  share_[k] = E_F * E_F / (E_F * E_F + E_d * E_d + 1e-20);
}

// The frame shows where the point of the canvas under the tip was then, and where it was forecast.
void FeltMotion::judge(const CanvasBelief& belief) noexcept {
  const double at = belief.last.time;
  if (at <= judged_at_) return;
  std::size_t back = 0;
  while (back < count_ && step(back).time > at + 0.5 * step(back).dt) ++back;
  if (back >= count_) return;
  const Step& then = step(back);
  const double since = at - judged_at_, gain = std::min(since, 0.1) / kFeltScoreTime;
  judged_at_ = at;
  const Vector3d off = belief.last.X_WK * (then.X_WK.inverse() * then.p) - then.p;
  const Vector3d& n = then.axes[along_normal];
  if (!n.isZero(0.0)) stamps_.add(n.dot(then.v), then.height - n.dot(off), since);
  for (int k = 0; k < kDirections; ++k) {
    if (then.axes[k].isZero(0.0)) continue;
    Score& s = scores_[k];
    s.without += gain * (std::pow(then.axes[k].dot(off), 2) - s.without);
    s.with += gain * (std::pow(then.axes[k].dot(off - then.d[k]), 2) - s.with);
    weigh(k, noise_at(belief, then.p, then.axes[k]));
  }
}

void FeltMotion::add_up_anew(const CanvasBelief& belief) noexcept {
  d_.fill(Vector3d::Zero());
  double since = 0.0;
  std::size_t oldest = 0;
  while (oldest < count_ && step(oldest).time > belief.last.time) ++oldest;
  for (std::size_t back = oldest; back-- > 0;) {
    const Step& s = step(back);
    since += s.dt;
    for (int k = 0; k < kDirections; ++k) d_[k] += s.dt * s.axes[k] * s.axes[k].dot(s.v);
    if (back % kStride != 0) continue;
    const Vector3d v = forecast(belief, s.time - 0.5 * since).velocity_at(s.p);
    for (int k = 0; k < kDirections; ++k) d_[k] -= since * s.axes[k] * s.axes[k].dot(v);
    since = 0.0;
  }
}

void FeltMotion::update(const CanvasBelief& belief, const PenTouch& pen, double time) noexcept {
  if (!belief.known) return;
  const double dt = count_ > 0 ? std::clamp(time - time_, 0.0, 0.02) : 0.0;
  time_ = time;
  const FrameMotion canvas = forecast(belief, time);
  // From the canvas as the law has it to the forecast without what is felt.
  const Vector3d forecast_off = canvas.X_WK * (pen.X_WK.inverse() * pen.p) - pen.p;
  Step s{time, dt, canvas.X_WK, pen.p, pen.v, pen.height - pen.n.dot(forecast_off), {}, {}};
  s.axes.fill(Vector3d::Zero());
  const double press = pen.touches ? pen.n.dot(pen.force) : 0.0;
  if (press > kLeastPress) {
    s.axes[along_normal] = pen.n;
    const Vector3d aside = pen.n.cross(pen.force);
    if (aside.norm() > kLeastFriction * press) s.axes[across_slip] = aside.normalized();
  }
  const Vector3d beyond = pen.v - canvas.velocity_at(pen.p);
  for (int k = 0; k < kDirections; ++k) {
    const Vector3d rate = s.axes[k] * s.axes[k].dot(beyond);
    d_[k] += dt * rate;
    if (d_[k].norm() > kFurthest) d_[k] *= kFurthest / d_[k].norm();
    rate_[k] += std::min(1.0, kRateFilter * dt) * (rate - rate_[k]);
  }
  const bool seen = belief.frames != frames_;
  frames_ = belief.frames;
  if (seen) judge(belief);
  steps_[next_] = s;
  next_ = (next_ + 1) % kMost;
  count_ = std::min(count_ + 1, kMost);
  expect(belief);
  if (seen) add_up_anew(belief);
  steps_[(next_ + kMost - 1) % kMost].d = d_;
}

CanvasShift FeltMotion::shift(double time) const noexcept {
  const double since = std::clamp(time - time_, 0.0, 0.02);
  CanvasShift out;
  for (int k = 0; k < kDirections; ++k) {
    out.d += share_[k] * (d_[k] + since * rate_[k]);
    out.v += share_[k] * rate_[k];
  }
  const bool touches = count_ > 0 && !step(0).axes[across_slip].isZero(0.0);
  if (touches) out.unfelt = 1.0 - (share_[along_normal] + share_[across_slip]) / 3.0;
  out.across = share_[across_slip] * rate_[across_slip];
  return out;
}

}  // namespace impedraw

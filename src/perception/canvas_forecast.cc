#include "impedraw/perception/canvas_forecast.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "impedraw/common/rotations.h"

namespace impedraw {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kLever = 0.15;       // from the centre to where a turn's error counts [m]
constexpr double kLeastTurn = 2e-3;   // below it nothing turns [rad/s]
constexpr double kTurned = 0.5;       // so far, an axis shows that it moves itself [rad]
constexpr double kLeastTrend = 5e-4;  // beside a swing [m/s]
constexpr std::array<double, 8> kWindows = {12.0, 10.0, 8.0, 6.0, 4.5, 3.0, 1.5, 0.75};  // [s]
constexpr double kShortestSwing = 3.0;  // a window [s]
// Jolts leave so much of a course that counts nevertheless, over so long a window [s].
constexpr double kJolted = 0.3, kLongEnough = 5.0;

// Six coordinates at one time.
struct Row {
  double time;
  Vector3d p, phi;
};
using Rows = std::span<const Row>;

// V with p = p_0 + V v: ∫ exp(ω s) ds from 0 to t.
Matrix3d screw(const Vector3d& w, double t) {
  const double turn = w.norm();
  if (turn * std::abs(t) < 1e-6) return t * Matrix3d::Identity();
  Matrix3d S;
  S << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  const double a = turn * t;
  return t * Matrix3d::Identity() + (1.0 - std::cos(a)) / (turn * turn) * S +
         (a - std::sin(a)) / (turn * turn * turn) * S * S;
}

Rows since(Rows rows, double window) {
  const double first = rows.back().time - window - 1e-9;
  std::size_t k = 0;
  while (rows[k].time < first) ++k;
  return rows.subspan(k);
}

Vector3d mean(Rows rows, Vector3d Row::*x) {
  Vector3d sum = Vector3d::Zero();
  for (const Row& row : rows) sum += row.*x;
  return sum / static_cast<double>(rows.size());
}

// RMS distance from the mean.
double spread(Rows rows, Vector3d Row::*x) {
  const Vector3d middle = mean(rows, x);
  double square = 0.0;
  for (const Row& row : rows) square += (row.*x - middle).squaredNorm();
  return std::sqrt(square / static_cast<double>(rows.size()));
}

// Least squares of x = a + b t, t counted from the last row. Returns the RMS of what is left.
double fit_line(Rows rows, Vector3d Row::*x, Vector3d* a, Vector3d* b) {
  double n = 0.0, t1 = 0.0, t2 = 0.0;
  Vector3d x1 = Vector3d::Zero(), xt = Vector3d::Zero();
  for (const Row& row : rows) {
    const double t = row.time - rows.back().time;
    n += 1.0, t1 += t, t2 += t * t;
    x1 += row.*x, xt += t * (row.*x);
  }
  const double det = n * t2 - t1 * t1;
  *b = det > 0.0 ? Vector3d((n * xt - t1 * x1) / det) : Vector3d::Zero();
  *a = (x1 - t1 * *b) / n;
  double square = 0.0;
  for (const Row& row : rows)
    square += (row.*x - *a - (row.time - rows.back().time) * *b).squaredNorm();
  return std::sqrt(square / n);
}

// The same of p = p_0 + V(t) v + u t for a known ω. `moves`: else u is 0.
double fit_screw(Rows rows, const Vector3d& w, bool moves, Vector3d* p_0, Vector3d* v,
                 Vector3d* u) {
  using Vector9 = Eigen::Matrix<double, 9, 1>;
  Eigen::Matrix<double, 9, 9> A = 1e-9 * Eigen::Matrix<double, 9, 9>::Identity();
  Vector9 b = Vector9::Zero();
  Eigen::Matrix<double, 3, 9> J = Eigen::Matrix<double, 3, 9>::Zero();
  J.leftCols<3>().setIdentity();
  for (const Row& row : rows) {
    const double t = row.time - rows.back().time;
    J.middleCols<3>(3) = screw(w, t);
    if (moves) J.rightCols<3>() = t * Matrix3d::Identity();
    A += J.transpose() * J;
    b += J.transpose() * row.p;
  }
  const Vector9 x = A.ldlt().solve(b);
  *p_0 = x.head<3>();
  *v = x.segment<3>(3);
  *u = x.tail<3>();
  double square = 0.0;
  for (const Row& row : rows) {
    const double t = row.time - rows.back().time;
    square += (row.p - *p_0 - screw(w, t) * *v - t * *u).squaredNorm();
  }
  return std::sqrt(square / static_cast<double>(rows.size()));
}

// The same with sinusoids; infinite where there are none. sigma: of a coordinate's error.
double fit_waves(Rows rows, Vector3d Row::*x, double sigma, double least_trend, AxisWave* waves) {
  std::vector<AxisSample> samples(rows.size());
  double square = 0.0;
  bool any = false;
  for (int i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < rows.size(); ++k)
      samples[k] = {rows[k].time, (rows[k].*x)[i], sigma * sigma};
    AxisWave wave = WaveFit::fit(samples, {}, true);
    any = any || wave.fitted;
    // A trend is worth its name if it is more than what a swing's ends leave.
    if (std::abs(wave.v0) < least_trend) {
      wave.x0 -= 0.5 * (rows.back().time - rows.front().time) * wave.v0;
      wave.v0 = 0.0;
    }
    for (const AxisSample& s : samples) square += std::pow(s.x - wave.at(s.time).x, 2);
    waves[i] = wave;
  }
  return any ? std::sqrt(square / static_cast<double>(rows.size()))
             : std::numeric_limits<double>::infinity();
}

// True if sinusoids, fitted before the last kFresh, would have foretold it: those that bend round a
// start or a stop would not.
bool foretold(Rows rows, Vector3d Row::*x, double sigma, double least_trend) {
  constexpr double kFresh = 1.5;                   // [s]
  constexpr double kOften = 5.0, kOfSwing = 0.05;  // of the noise; of the swing's size
  std::size_t k = rows.size();
  while (k > 0 && rows[k - 1].time > rows.back().time - kFresh) --k;
  std::array<AxisWave, 3> waves{};
  if (k < 2 || !std::isfinite(fit_waves(rows.first(k), x, sigma, least_trend, waves.data())))
    return false;
  double square = 0.0, size = 0.0;
  for (const AxisWave& w : waves)
    for (int i = 0; i < AxisWave::kSinusoids; ++i) size += std::hypot(w.cosine[i], w.sine[i]);
  for (std::size_t i = k; i < rows.size(); ++i) {
    const double t = rows[i].time;
    square +=
        (rows[i].*x - Vector3d(waves[0].at(t).x, waves[1].at(t).x, waves[2].at(t).x)).squaredNorm();
  }
  return std::sqrt(square / static_cast<double>(rows.size() - k)) <=
         std::max(kOften * sigma, kOfSwing * size);
}

// Its rate, of the largest of three [Hz].
double swing_rate(const AxisWave* waves) {
  double largest = 0.0, rate = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < AxisWave::kSinusoids; ++k) {
      const double amplitude = std::hypot(waves[i].cosine[k], waves[i].sine[k]);
      if (waves[i].rate[k] == 0.0 || amplitude <= largest) continue;
      largest = amplitude;
      rate = waves[i].rate[k];
    }
  return rate / (2.0 * std::numbers::pi);
}

}  // namespace

Pose CanvasForecast::at(double time) const noexcept {
  const auto wave_at = [&](int first) {
    return Vector3d(waves_[first].at(time).x, waves_[first + 1].at(time).x,
                    waves_[first + 2].at(time).x);
  };
  const double t = time - origin_;
  const Vector3d phi = turn_ == Course::swinging ? wave_at(3) : Vector3d(phi_ + t * w_);
  const Vector3d p =
      shift_ == Course::swinging ? wave_at(0) : Vector3d(p_ + screw(w_, t) * v_ + t * u_);
  Pose X;
  X.R = rotation(phi) * R_0_;
  X.p = p - X.R * centre_K_;
  return X;
}

CanvasForecast CanvasForecast::standing(const Pose& X_WK) {
  CanvasForecast f;
  f.shift_ = f.turn_ = Course::steady;
  f.R_0_ = X_WK.R;
  f.p_ = X_WK.p;
  f.window_ = std::numeric_limits<double>::infinity();
  return f;
}

std::string CanvasForecast::text() const {
  const auto course = [](Course c, const char* swings, double rate, const char* moves, double speed,
                         double least, const char* unit, const char* wanders) -> std::string {
    if (c == Course::swinging) return fmt::format("{} at {:.2f} Hz", swings, rate);
    if (c == Course::unsteady) return wanders;
    return speed < least ? "" : fmt::format("{} at {:.3f} {}", moves, speed, unit);
  };
  const std::string shift = course(shift_, "swings", swing_rate(waves_.data()), "moves", v_.norm(),
                                   1e-3, "m/s", "is jolted"),
                    turn = course(turn_, "rocks", swing_rate(waves_.data() + 3), "turns", w_.norm(),
                                  kLeastTurn, "rad/s", "is tilted to and fro");
  if (shift.empty() && turn.empty()) return "stands";
  return shift + (shift.empty() || turn.empty() ? "" : " and ") + turn;
}

CanvasHistory::CanvasHistory(const Vector3d& centre_K) : centre_K_(centre_K), samples_(kMost) {}

void CanvasHistory::add(double time, const Pose& X_WK) noexcept {
  if (count_ > 0) {
    const double gap = time - samples_[(next_ + kMost - 1) % kMost].time;
    if (gap < kEvery - 1e-9) return;
    if (gap > kSpan) count_ = 0;
  }
  samples_[next_] = {time, X_WK};
  next_ = (next_ + 1) % kMost;
  count_ = std::min(count_ + 1, kMost);
}

CanvasForecast CanvasHistory::forecast() const {
  using Course = CanvasForecast::Course;
  CanvasForecast f;
  f.centre_K_ = centre_K_;
  if (count_ == 0) {
    f.p_ = centre_K_;
    f.shift_ = f.turn_ = Course::steady;
    return f;
  }
  std::vector<Row> rows(count_);
  const auto sample = [&](std::size_t k) -> const Sample& {
    return samples_[(next_ + kMost - count_ + k) % kMost];
  };
  f.R_0_ = sample(count_ - 1).X_WK.R;
  Vector3d near = Vector3d::Zero();
  for (std::size_t k = count_; k-- > 0;) {
    const Sample& s = sample(k);
    const Eigen::AngleAxisd turned(s.X_WK.R * f.R_0_.transpose());
    Vector3d phi = turned.angle() * turned.axis();
    if (phi.norm() > 1.0) {  // more than half a turn ago
      const double turn = 2.0 * std::numbers::pi, angle = phi.norm();
      phi += phi / angle * turn * std::round(phi.dot(near - phi) / angle / turn);
    }
    rows[k] = {s.time, s.X_WK * centre_K_, phi};
    near = phi;
  }
  f.origin_ = rows.back().time;
  const double span = f.origin_ - rows.front().time;

  // Longest window first, down to `shortest`; the fits return the RMS of what they leave.
  f.window_ = span;
  const auto find = [&](double most, double shortest, const auto& steady, const auto& swinging) {
    bool whole = false;
    for (const double window : kWindows) {
      if (window >= span && whole) continue;  // the same once more
      whole = whole || window >= span;
      const Rows last = since(rows, window);
      const double length = last.back().time - last.front().time;
      if (length < shortest) break;
      const bool line = steady(last) <= most;
      if (!line && !(length >= kShortestSwing && swinging(last, most) <= most)) continue;
      f.window_ = std::min(f.window_, length);
      return line ? Course::steady : Course::swinging;
    }
    return Course::unsteady;
  };
  // lever: from a coordinate to the way that counts [m].
  const auto course = [&](Vector3d Row::*x, double lever, const auto& steady, AxisWave* waves) {
    const auto swinging = [&](Rows last, double most) {
      const double sigma = 0.3 * most / lever, trend = kLeastTrend / lever;
      const double left = fit_waves(last, x, sigma, trend, waves);
      return lever * left <= most && foretold(last, x, sigma, trend)
                 ? lever * left
                 : std::numeric_limits<double>::infinity();
    };
    const Course exact = find(kUnexplained, 0.0, steady, swinging);
    if (exact != Course::unsteady) return exact;
    return find(kJolted * lever * spread(rows, x), kLongEnough, steady, swinging);
  };
  f.turn_ = course(
      &Row::phi, kLever,
      [&](Rows last) { return kLever * fit_line(last, &Row::phi, &f.phi_, &f.w_); },
      f.waves_.data() + 3);
  if (f.turn_ == Course::unsteady) f.phi_ = mean(rows, &Row::phi);
  if (f.turn_ != Course::steady || f.w_.norm() < kLeastTurn) f.w_.setZero();
  f.shift_ = course(
      &Row::p, 1.0,
      [&](Rows last) {
        const double left = fit_screw(last, f.w_, false, &f.p_, &f.v_, &f.u_);
        const double turned = f.w_.norm() * (last.back().time - last.front().time);
        if (left <= kUnexplained || turned < kTurned) return left;
        return fit_screw(last, f.w_, true, &f.p_, &f.v_, &f.u_);
      },
      f.waves_.data());
  if (f.shift_ == Course::unsteady) f.p_ = mean(rows, &Row::p), f.v_ = f.u_ = Vector3d::Zero();
  double square = 0.0;
  const Rows explained = since(rows, f.window_);
  for (const Row& row : explained) square += (row.p - f.at(row.time) * centre_K_).squaredNorm();
  f.unexplained_ = std::sqrt(square / static_cast<double>(explained.size()));
  return f;
}

}  // namespace impedraw

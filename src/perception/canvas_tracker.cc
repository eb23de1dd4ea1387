#include "impedraw/perception/canvas_tracker.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/common/rotation_vector.h"
#include "impedraw/perception/rigid_fit.h"

namespace impedraw {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr std::size_t kMostEntries = 1200, kFewestOld = 60;
constexpr double kLeastSpread = 5e-3;  // of marks beside a line [m]
constexpr double kLeastAngle = 0.02;   // of the rotation that two cameras' noise may leave [rad]
// How sure the prediction is in directions that the shape leaves open [m], [rad]; and how sure the
// shape can be at best, in both.
constexpr double kOpenShift = 0.01, kOpenTurn = 0.1, kShapeFloor = 3e-5;
constexpr double kReferAnew = 1.0;          // of φ [rad]
constexpr double kScoreTime = 1.0;          // [s]
constexpr double kSearchPeriod = 1.0 / 12;  // from one axis to the next [s]

Vector3d rotation_vector(const Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

Matrix3d cross(const Vector3d& v) {
  Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

// ω = A(φ) φ̇ with exp(φ) as rotation and ω in the fixed frame.
Matrix3d rate_map(const Vector3d& phi) {
  const double t2 = phi.squaredNorm(), t = std::sqrt(t2);
  const double b = t < 1e-4 ? 0.5 - t2 / 24.0 : (1.0 - std::cos(t)) / t2;
  const double c = t < 1e-4 ? 1.0 / 6.0 - t2 / 120.0 : (t - std::sin(t)) / (t2 * t);
  const Matrix3d S = cross(phi);
  return Matrix3d::Identity() + b * S + c * S * S;
}

}  // namespace

const std::array<CanvasTracker::Model, CanvasTracker::kFilters> CanvasTracker::kBank = {
    {{1, 1e-10}, {2, 1e-9}, {2, 1e-5}, {3, 1e-3}, {3, 0.1}}};
const std::array<double, CanvasTracker::kBands> CanvasTracker::kCutoffs = {0.4, 0.7, 1.1, 1.8, 3.0};

CanvasTracker::CanvasTracker(const CanvasTrackerSettings& settings,
                             std::unique_ptr<CanvasShape> shape)
    : settings_(settings), shape_(std::move(shape)) {
  for (const Fiducial& f : settings.fiducials.points) marks_K_.push_back(f.p_K);
  require_in_range("perception.fiducials", FiducialSettings::Limits::noise,
                   settings.fiducials.noise);
  entries_.reserve(kMostEntries + 1);
  for (auto& samples : samples_) samples.reserve(kMostEntries + 1);
  if (shape_ && marks_K_.empty()) {
    centre_K_ = shape_->centre_K();
    return;
  }
  if (marks_K_.size() < 3 || marks_K_.size() > CanvasFrame::kMostMarks)
    throw InputError(fmt::format(
        "perception.fiducials.points has {} points; a canvas that moves is found by 3 to {}, or by "
        "its shape (perception.frames.depth)",
        marks_K_.size(), CanvasFrame::kMostMarks));
  const double spread = spread_beside_line(marks_K_);
  if (!(spread >= kLeastSpread))
    throw InputError(fmt::format(
        "perception.fiducials.points lie on a straight line (to {:.1f} mm), about which nothing "
        "tells how the canvas turns; at least {:.0f} mm beside it are needed",
        1e3 * spread, 1e3 * kLeastSpread));
  centre_K_ = Vector3d::Zero();
  for (const Vector3d& p : marks_K_) centre_K_ += p / static_cast<double>(marks_K_.size());
}

// The pose that the frame tells, with the variance of each coordinate. Marks and shape count by
// their information; without marks the prediction counts a little, for what the shape leaves open.
bool CanvasTracker::measure(const CanvasFrame& frame, Entry* entry) noexcept {
  Matrix6 information = Matrix6::Zero();  // about the centre, in W
  const bool marked = measure_marks(frame, entry, &information);
  if (marked) open_ = 0;
  if (shape_ && frame.depth) {
    const Pose predicted = marked             ? entry->X_WK
                           : entries_.empty() ? settings_.X_WK
                                              : predict(frame.time).motion.X_WK;
    const ShapeRegistration& found = shape_->look(frame, predicted);
    if (found.found) {
      if (!marked) {
        open_ = found.open;
        entry->time = frame.time;
        entry->X_WK = predicted;
        information.diagonal() << Vector3d::Constant(1.0 / (kOpenShift * kOpenShift)),
            Vector3d::Constant(1.0 / (kOpenTurn * kOpenTurn));
      }
      // About the centre, and no surer than cameras are placed.
      const Vector3d centre = found.X_WK * centre_K_;
      Matrix6 to_c = Matrix6::Identity();  // ξ about c from ξ about the centre
      to_c.topRightCorner<3, 3>() = -cross(found.c_W - centre);
      Matrix6 shape = to_c.transpose() * found.information * to_c;
      const Matrix6 floor = Vector6::Constant(kShapeFloor * kShapeFloor).asDiagonal();
      shape = shape * (Matrix6::Identity() + floor * shape).inverse();
      const Pose off = found.X_WK * entry->X_WK.inverse();
      Vector6 xi;
      xi << found.X_WK * centre_K_ - entry->X_WK * centre_K_, rotation_vector(off.R);
      information += shape;
      const Matrix6 covariance = information.inverse();
      const Vector6 step = covariance * (shape * xi);
      const Vector3d c = entry->X_WK * centre_K_ + step.head<3>();
      entry->X_WK.R = rotation(step.tail<3>()) * entry->X_WK.R;
      entry->X_WK.p = c - entry->X_WK.R * centre_K_;
      for (int i = 0; i < kAxes; ++i) entry->variance[i] = covariance(i, i);
      shape_->fuse(entry->X_WK);
      return true;
    }
  }
  return marked;
}

// Of the marks alone.
bool CanvasTracker::measure_marks(const CanvasFrame& frame, Entry* entry,
                                  Matrix6* information) const noexcept {
  std::array<Vector3d, CanvasFrame::kMostMarks> p_K, p_W;
  std::size_t n = 0;
  for (const FoundMark& m : frame.found()) {
    if (m.mark < 0 || m.mark >= static_cast<int>(marks_K_.size()) || !m.p_W.allFinite()) continue;
    p_K[n] = marks_K_[static_cast<std::size_t>(m.mark)];
    p_W[n++] = m.p_W;
  }
  const std::span<const Vector3d> known(p_K.data(), n), seen(p_W.data(), n);
  if (spread_beside_line(known) < kLeastSpread) return false;
  const RigidFit fit = fit_rigid(known, seen);
  const double noise = std::max(settings_.fiducials.noise, 1e-6), variance = noise * noise;
  entry->time = frame.time;
  entry->X_WK = fit.X_WK;
  // The centre of all marks may lie beside that of those found.
  const Vector3d r = fit.X_WK.R * (centre_K_ - fit.centre_K);
  const Matrix3d S = cross(r);
  Matrix6 covariance;
  covariance.topLeftCorner<3, 3>() =
      fit.position_variance * Matrix3d::Identity() + S * fit.rotation_covariance * S.transpose();
  covariance.topRightCorner<3, 3>() = -S * fit.rotation_covariance;
  covariance.bottomLeftCorner<3, 3>() = covariance.topRightCorner<3, 3>().transpose();
  covariance.bottomRightCorner<3, 3>() = fit.rotation_covariance;
  covariance *= variance;
  for (int i = 0; i < kAxes; ++i) entry->variance[i] = covariance(i, i);
  if (shape_) *information = covariance.inverse();
  return entry->variance[3] + entry->variance[4] + entry->variance[5] < kLeastAngle * kLeastAngle;
}

// Its coordinates, φ next to `near`.
void CanvasTracker::express(Entry* entry, const Vector3d& near) const noexcept {
  const Vector3d c = entry->X_WK * centre_K_;
  Vector3d phi = rotation_vector(entry->X_WK.R * R_0_.transpose());
  const double angle = phi.norm();
  if (angle > 1.0) {
    const double turn = 2.0 * std::numbers::pi;
    phi += phi / angle * turn * std::round(phi.dot(near - phi) / angle / turn);
  }
  for (int i = 0; i < 3; ++i) {
    entry->x[i] = c[i];
    entry->x[3 + i] = phi[i];
  }
}

// Runs the filters again over the entries from `first` on.
void CanvasTracker::update_from(std::size_t first) noexcept {
  for (std::size_t k = first; k < entries_.size(); ++k) {
    Entry& e = entries_[k];
    for (int m = 0; m < kFilters; ++m)
      for (int i = 0; i < kAxes; ++i) {
        AxisFilter& f = e.filters[m][i];
        if (k == 0) {
          f = AxisFilter::started(e.x[i], e.variance[i], kBank[m].order);
          continue;
        }
        f = entries_[k - 1].filters[m][i];
        f.predict(e.time - entries_[k - 1].time, kBank[m].noise, kBank[m].order);
        f.measure(e.x[i], e.variance[i]);
      }
  }
}

AxisState CanvasTracker::model_state(const Entry& from, int model, int axis,
                                     double time) const noexcept {
  if (model < kFilters) return from.filters[model][axis].ahead(time - from.time);
  if (model < kSwinging) return from.bands[model - kFilters][axis].at(time);
  return from.waves[axis].at(time);
}

bool CanvasTracker::holds(const Entry& entry, int model, int axis) const noexcept {
  if (model < kFilters) return true;
  return model < kSwinging ? entry.banded[axis] : entry.waves[axis].fitted;
}

std::array<double, CanvasTracker::kModels> CanvasTracker::weights(int axis) const noexcept {
  // All errors hold the noise of what they are compared with: what one has beyond the best counts.
  // Of models that do as well, the simpler one is to be preferred.
  constexpr double kAlike = 0.03;  // in shares of that noise
  const Score& score = scores_[axis];
  const auto known = [&](int m) {
    return holds(entries_.back(), m, axis) && (score.weight > 0.0 || m < kFilters);
  };
  double best = 1e300;
  for (int m = 0; m < kModels; ++m)
    if (known(m)) best = std::min(best, score.square[m]);
  std::array<double, kModels> w{};
  double sum = 0.0;
  for (int m = 0; m < kModels; ++m) {
    if (!known(m)) continue;
    const double beyond = 1.0 + (score.square[m] - best) / (kAlike * score.noise + 1e-14);
    const double simple = m < kFilters ? std::pow(0.3, m) : m < kSwinging ? 1e-2 : 0.1;
    w[m] = simple / (beyond * beyond * beyond);
    sum += w[m];
  }
  for (double& share : w) share /= sum;
  return w;
}

AxisState CanvasTracker::blend(const Entry& from, int axis, double time) const noexcept {
  const std::array<double, kModels> w = weights(axis);
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

// Compares what was predicted for the entry's time, from what was known one lateness before it.
void CanvasTracker::judge(const Entry& entry) noexcept {
  const double known = entry.time - lateness_;
  std::size_t k = entries_.size();
  while (k > 0 && entries_[k - 1].time > known) --k;
  if (k < 2) return;
  const Entry& from = entries_[k - 1];
  const double gap = k < 2 ? 0.03 : std::max(1e-3, entries_.back().time - entries_[k - 2].time);
  const double gain = std::min(1.0, std::min(gap, 0.03) / kScoreTime);
  for (int i = 0; i < kAxes; ++i) {
    Score& s = scores_[i];
    s.weight = s.weight + gain * (1.0 - s.weight);
    const double share = gain / s.weight;  // the first count in full
    double worst = 0.0;
    for (int m = 0; m < kModels; ++m) {
      // A model that did not hold yet is no better than the worst that did.
      double square = 4.0 * worst;
      if (holds(from, m, i)) {
        const double off = model_state(from, m, i, entry.time).x - entry.x[i];
        square = off * off;
        worst = std::max(worst, square);
      }
      s.square[m] += share * (square - s.square[m]);
    }
    const double off = blend(from, i, entry.time).x - entry.x[i];
    s.blended += share * (off * off - s.blended);
    s.noise += share * (entry.variance[i] - s.noise);
  }
}

// φ grows large on a turntable, and its map singular at a full turn: a new R_0.
void CanvasTracker::refer_anew() noexcept {
  const auto phi_of = [](const auto& s) { return Vector3d(s[3].x, s[4].x, s[5].x); };
  const Matrix3d R = rotation(phi_of(smooth_)) * R_0_;
  const Vector3d w = rate_map(phi_of(smooth_)) * Vector3d(smooth_[3].v, smooth_[4].v, smooth_[5].v);
  R_0_ = entries_.back().X_WK.R;
  const Vector3d phi = rotation_vector(R * R_0_.transpose()), rate = rate_map(phi).inverse() * w;
  for (int i = 0; i < 3; ++i) smooth_[3 + i] = {phi[i], rate[i], 0.0};

  Vector3d near = Vector3d::Zero();
  for (std::size_t k = entries_.size(); k-- > 0;) {
    express(&entries_[k], near);
    near = Vector3d(entries_[k].x[3], entries_[k].x[4], entries_[k].x[5]);
    for (int i = 3; i < kAxes; ++i) {
      entries_[k].waves[i] = {};
      entries_[k].banded[i] = false;
    }
  }
  update_from(0);
}

// One axis at a time searches for its frequencies; all follow with their amplitudes.
void CanvasTracker::fit_waves() noexcept {
  Entry& last = entries_.back();
  const bool search = last.time - searched_at_ >= kSearchPeriod || last.time < searched_at_;
  if (search) {
    searched_at_ = last.time;
    search_axis_ = (search_axis_ + 1) % kAxes;
  }
  for (int i = 0; i < kAxes; ++i) {
    const bool this_one = search && i == search_axis_;
    if (this_one || last.waves[i].fitted)
      last.waves[i] = WaveFit::fit(samples_[i], last.waves[i], this_one);
  }
}

// Frames of several cameras at one time are one sample.
void CanvasTracker::collect() noexcept {
  constexpr double kOneTime = 8e-3;  // [s]
  for (auto& samples : samples_) samples.clear();
  for (const Entry& e : entries_) {
    if (e.time < entries_.back().time - kWindow) continue;
    const bool same = !samples_[0].empty() && e.time - samples_[0].back().time < kOneTime;
    for (int i = 0; i < kAxes; ++i) {
      if (!same) {
        samples_[i].push_back({e.time, e.x[i], e.variance[i]});
        continue;
      }
      AxisSample& s = samples_[i].back();
      const double w = 1.0 / e.variance[i], have = 1.0 / s.variance, share = w / (w + have);
      s.x += share * (e.x[i] - s.x);
      s.variance = 1.0 / (w + have);
    }
  }
}

void CanvasTracker::fit_bands() noexcept {
  Entry& last = entries_.back();
  std::size_t first = samples_[0].size();
  while (first > 0 && samples_[0].size() - first < BandLimited::kMostSamples &&
         samples_[0][first - 1].time > last.time - BandLimited::kWindow)
    --first;
  const std::size_t n = samples_[0].size() - first;
  std::array<double, BandLimited::kMostSamples> times, weights, x;
  double mean = 0.0;
  for (std::size_t k = 0; k < n; ++k)
    mean += samples_[0][first + k].variance / static_cast<double>(n);
  for (std::size_t k = 0; k < n; ++k) {
    times[k] = samples_[0][first + k].time;
    weights[k] = mean / samples_[0][first + k].variance;
  }
  last.banded.fill(false);
  for (int m = 0; m < kBands; ++m) {
    if (!band_.set(kCutoffs[m], {times.data(), n}, {weights.data(), n})) return;
    for (int i = 0; i < kAxes; ++i) {
      for (std::size_t k = 0; k < n; ++k) x[k] = samples_[i][first + k].x;
      last.bands[m][i] = band_.predict({x.data(), n});
    }
  }
  last.banded.fill(true);
}

void CanvasTracker::add(const CanvasFrame& frame) noexcept {
  Entry entry;
  if (!std::isfinite(frame.time) || !measure(frame, &entry)) return;
  if (!entries_.empty() && frame.time < entries_.back().time - kWindow) return;
  if (entries_.empty()) R_0_ = entry.X_WK.R;
  Vector3d near = Vector3d::Zero();
  if (!entries_.empty())
    near = Vector3d(entries_.back().x[3], entries_.back().x[4], entries_.back().x[5]);
  express(&entry, near);
  if (!entries_.empty()) judge(entry);
  std::size_t at = entries_.size();
  while (at > 0 && entries_[at - 1].time > entry.time) --at;
  entries_.insert(entries_.begin() + static_cast<std::ptrdiff_t>(at), entry);
  if (at > 0) {
    entries_[at].waves = entries_[at - 1].waves;
    entries_[at].bands = entries_[at - 1].bands;
    entries_[at].banded = entries_[at - 1].banded;
  }
  update_from(at);
  std::size_t old = entries_.size() > kMostEntries ? kMostEntries / 4 : 0;
  while (old + 2 < entries_.size() && entries_[old].time < entries_.back().time - kWindow) ++old;
  if (old >= kFewestOld)  // not for each frame: the rest moves up
    entries_.erase(entries_.begin(), entries_.begin() + static_cast<std::ptrdiff_t>(old));
  if (Vector3d(entries_.back().x[3], entries_.back().x[4], entries_.back().x[5]).norm() >
      kReferAnew)
    refer_anew();
  collect();
  fit_bands();
  fit_waves();
}

CanvasEstimate CanvasTracker::estimate(const std::array<AxisState, kAxes>& s,
                                       double time) const noexcept {
  CanvasEstimate out;
  out.age = time - entries_.back().time;
  const auto of = [&s](int first, double AxisState::*member) {
    return Vector3d(s[first].*member, s[first + 1].*member, s[first + 2].*member);
  };
  const Vector3d c = of(0, &AxisState::x), c_v = of(0, &AxisState::v), c_a = of(0, &AxisState::a);
  const Vector3d phi = of(3, &AxisState::x), rate = of(3, &AxisState::v),
                 rise = of(3, &AxisState::a);
  FrameMotion& m = out.motion;
  m.X_WK.R = rotation(phi) * R_0_;
  m.w = rate_map(phi) * rate;
  constexpr double h = 1e-4;  // [s]
  m.alpha = (rate_map(phi + h * rate) * (rate + h * rise) -
             rate_map(phi - h * rate) * (rate - h * rise)) /
            (2.0 * h);
  const Vector3d r = -(m.X_WK.R * centre_K_);  // from the centre to K's origin
  m.X_WK.p = c + r;
  m.v = c_v + m.w.cross(r);
  m.a = c_a + m.alpha.cross(r) + m.w.cross(m.w.cross(r));
  out.centre_W = c;

  // What was off after one lateness grows with its square, as an unforeseen acceleration's effect.
  const double growth = std::max(1.0, out.age / lateness_);
  double position = 0.0;
  for (int i = 0; i < kAxes; ++i) {
    const double known = entries_.back().filters[2][i].P[0];
    const double off = std::max(0.0, scores_[i].blended - scores_[i].noise);
    const double square = known + off * std::pow(growth, 4);
    out.covariance(i < 3 ? 3 + i : i - 3, i < 3 ? 3 + i : i - 3) = square;
    if (i < 3) position += square;
  }
  const bool old = out.age > settings_.longest_age;
  const bool unsure = std::sqrt(position) > settings_.largest_error;
  out.status = old || unsure ? CanvasStatus::stale
               : open_ > 0   ? CanvasStatus::undetermined
                             : CanvasStatus::ok;
  return out;
}

CanvasEstimate CanvasTracker::predict(double time) const noexcept {
  if (entries_.empty()) return {};
  std::array<AxisState, kAxes> s;
  for (int i = 0; i < kAxes; ++i) s[i] = blend(entries_.back(), i, time);
  return estimate(s, time);
}

CanvasEstimate CanvasTracker::follow(double time) noexcept {
  if (entries_.empty()) return {};
  const double dt = time - smooth_time_;
  const bool anew = smooth_time_ < 0.0 || !(dt >= 0.0) || dt > 0.1;
  if (!anew)
    lateness_ += dt / kScoreTime * (std::clamp(time - entries_.back().time, 0.01, 0.3) - lateness_);
  for (int i = 0; i < kAxes; ++i) {
    const AxisState target =
        blend(entries_.back(), i, settings_.prediction ? time : entries_.back().time);
    AxisState& s = smooth_[i];
    if (anew) {
      s = target;
      continue;
    }
    const double a =
        target.a + kSmoothing * kSmoothing * (target.x - s.x) + 2.0 * kSmoothing * (target.v - s.v);
    s.x += dt * (s.v + 0.5 * dt * a);
    s.v += dt * a;
    // The corrections are the estimate's motion, not the canvas's: they are not fed forward.
    s.a += std::min(1.0, kSmoothing * dt) * (target.a - s.a);
  }
  smooth_time_ = time;
  return estimate(smooth_, time);
}

double CanvasTracker::position_error() const noexcept {
  return std::sqrt(scores_[0].blended + scores_[1].blended + scores_[2].blended);
}

const char* CanvasTracker::model(int axis) const noexcept {
  if (entries_.empty()) return "none";
  const std::array<double, kModels> w = weights(axis);
  const auto most = std::max_element(w.begin(), w.end()) - w.begin();
  if (most == kSwinging) return "swinging";
  if (most >= kFilters) return "band";
  static constexpr const char* kNames[] = {"standing", "steady", "drifting"};
  return kNames[kBank[static_cast<std::size_t>(most)].order - 1];
}

std::string CanvasTracker::open_directions() const {
  std::string text;
  for (int k = 0; shape_ && k < open_ && k < shape_->last().open; ++k)
    text += (k == 0 ? "" : ", or ") +
            shape_->last().open_directions[static_cast<std::size_t>(k)].text();
  return text;
}

}  // namespace impedraw

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
#include "impedraw/common/rotations.h"
#include "impedraw/perception/repeated_motion.h"
#include "impedraw/perception/rigid_fit.h"
#include "impedraw/perception/rotation_coordinates.h"

namespace impedraw {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr std::size_t kMostEntries = 1200, kFewestOld = 60;
constexpr double kLeastSpread = 5e-3;  // of marks beside a line [m]
constexpr double kLeastAngle = 0.02;   // of the rotation that two cameras' noise may leave [rad]
// Doubt of the prediction in directions that the shape leaves open [m], [rad]; and the doubt of the
// shape can be at best, in both.
constexpr double kOpenShift = 0.01, kOpenTurn = 0.1, kShapeFloor = 3e-5;
constexpr double kReferAnew = 1.0;          // of φ [rad]
constexpr double kScoreTime = 1.0;          // [s]
constexpr double kSearchPeriod = 1.0 / 12;  // from one axis to the next [s]

}  // namespace

CanvasTracker::CanvasTracker(const CanvasTrackerSettings& settings,
                             std::unique_ptr<CanvasShape> shape)
    : settings_(settings), shape_(std::move(shape)) {
  belief_.prediction = settings.prediction;
  belief_.longest_age = settings.longest_age;
  belief_.largest_error = settings.largest_error;
  for (const Fiducial& f : settings.fiducials.points) marks_K_.push_back(f.p_K);
  require_in_range("perception.fiducials", FiducialSettings::Limits::noise,
                   settings.fiducials.noise);
  entries_.reserve(kMostEntries + 1);
  for (auto& samples : samples_) samples.reserve(kMostEntries + 1);
  if (shape_ && marks_K_.empty()) {
    belief_.centre_K = shape_->centre_K();
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
  belief_.centre_K = Vector3d::Zero();
  for (const Vector3d& p : marks_K_) belief_.centre_K += p / static_cast<double>(marks_K_.size());
}

// The pose that the frame tells, with the variance of each coordinate. Marks and shape count by
// their information; without marks the prediction counts a little, for what the shape leaves open.
bool CanvasTracker::measure(const CanvasFrame& frame, Entry* entry) noexcept {
  Matrix6 information = Matrix6::Zero();  // about the centre, in W
  const bool marked = measure_marks(frame, entry, &information);
  if (marked) belief_.open = 0;
  if (shape_ && frame.depth) {
    const Pose predicted = marked             ? entry->X_WK
                           : entries_.empty() ? settings_.X_WK
                                              : predict(frame.time).motion.X_WK;
    const ShapeRegistration& found = shape_->look(frame, predicted);
    if (found.found) {
      if (!marked) {
        belief_.open = found.open;
        belief_.open_directions = found.open_directions;
        entry->time = frame.time;
        entry->X_WK = predicted;
        information.diagonal() << Vector3d::Constant(1.0 / (kOpenShift * kOpenShift)),
            Vector3d::Constant(1.0 / (kOpenTurn * kOpenTurn));
      }
      // About the centre, and no surer than cameras are placed.
      const Vector3d centre = found.X_WK * belief_.centre_K;
      Matrix6 to_c = Matrix6::Identity();  // ξ about c from ξ about the centre
      to_c.topRightCorner<3, 3>() = -cross_matrix(found.c_W - centre);
      Matrix6 shape = to_c.transpose() * found.information * to_c;
      const Matrix6 floor = Vector6::Constant(kShapeFloor * kShapeFloor).asDiagonal();
      shape = shape * (Matrix6::Identity() + floor * shape).inverse();
      const Pose off = found.X_WK * entry->X_WK.inverse();
      Vector6 xi;
      xi << found.X_WK * belief_.centre_K - entry->X_WK * belief_.centre_K, rotation_vector(off.R);
      information += shape;
      const Matrix6 covariance = information.inverse();
      const Vector6 step = covariance * (shape * xi);
      const Vector3d c = entry->X_WK * belief_.centre_K + step.head<3>();
      entry->X_WK.R = rotation(step.tail<3>()) * entry->X_WK.R;
      entry->X_WK.p = c - entry->X_WK.R * belief_.centre_K;
      for (int i = 0; i < kAxes; ++i) entry->variance[i] = covariance(i, i);
      shape_->fuse(entry->X_WK);
      return true;
    }
  }
  return marked;
}

// A pose by the marks alone.
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
  const Vector3d r = fit.X_WK.R * (belief_.centre_K - fit.centre_K);
  const Matrix3d S = cross_matrix(r);
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
  const Vector3d c = entry->X_WK * belief_.centre_K;
  Vector3d phi = rotation_vector(entry->X_WK.R * belief_.R_0.transpose());
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
          f = AxisFilter::started(e.x[i], e.variance[i], CanvasBelief::kBank[m].order);
          continue;
        }
        f = entries_[k - 1].filters[m][i];
        f.predict(e.time - entries_[k - 1].time, CanvasBelief::kBank[m]);
        f.measure(e.x[i], e.variance[i]);
      }
  }
}

// Compares what was predicted for the entry's time, from what was known one lateness before it.
void CanvasTracker::judge(const Entry& entry) noexcept {
  const double known = entry.time - smoothed_.lateness();
  std::size_t k = entries_.size();
  while (k > 0 && entries_[k - 1].time > known) --k;
  if (k < 2) return;
  const Entry& from = entries_[k - 1];
  const double gap = k < 2 ? 0.03 : std::max(1e-3, entries_.back().time - entries_[k - 2].time);
  const double gain = std::min(1.0, std::min(gap, 0.03) / kScoreTime);
  for (int i = 0; i < kAxes; ++i) {
    Score& s = belief_.scores[i];
    s.weight = s.weight + gain * (1.0 - s.weight);
    const double share = gain / s.weight;  // the first count in full
    double worst = 0.0;
    for (int m = 0; m < kModels; ++m) {
      // A model that did not hold yet is no better than the worst that did.
      double square = 4.0 * worst;
      if (belief_.holds(from, m, i)) {
        const double off = belief_.model_state(from, m, i, entry.time).x - entry.x[i];
        square = off * off;
        worst = std::max(worst, square);
      }
      s.square[m] += share * (square - s.square[m]);
    }
    const double off = belief_.blend(from, i, entry.time).x - entry.x[i];
    s.blended += share * (off * off - s.blended);
    s.noise += share * (entry.variance[i] - s.noise);
  }
}

// φ grows large on a turntable, and its map singular at a full turn: a new R_0.
void CanvasTracker::refer_anew() noexcept {
  belief_.R_0 = entries_.back().X_WK.R;
  Vector3d near = Vector3d::Zero();
  for (std::size_t k = entries_.size(); k-- > 0;) {
    express(&entries_[k], near);
    near = Vector3d(entries_[k].x[3], entries_[k].x[4], entries_[k].x[5]);
    for (int i = 3; i < kAxes; ++i) {
      entries_[k].waves[i] = {};
      entries_[k].fitted[i] = false;
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

// Frames within kOneSample are one sample, at their mean time: it is off by half the acceleration
// times the variance of their times. As many as may be fitted last for the window.
void CanvasTracker::collect() noexcept {
  constexpr double kOneSample = kWindow / WaveFit::kMostSamples;  // [s]
  for (auto& samples : samples_) samples.clear();
  double first = 0.0, sum = 0.0;  // time of a sample's first frame; sum of weights
  for (const Entry& e : entries_) {
    if (e.time < entries_.back().time - kWindow) continue;
    const double weight = 1.0 / (e.variance[0] + e.variance[1] + e.variance[2]);
    const bool same = !samples_[0].empty() && e.time - first < kOneSample;
    if (!same) {
      first = e.time;
      sum = 0.0;
    }
    sum += weight;
    const double share = weight / sum;
    for (int i = 0; i < kAxes; ++i) {
      if (!same) samples_[i].push_back({e.time, e.x[i], e.variance[i]});
      AxisSample& s = samples_[i].back();
      s.time += share * (e.time - s.time);
      s.x += share * (e.x[i] - s.x);
      if (same)
        s.variance = (1.0 - share) * (1.0 - share) * s.variance + share * share * e.variance[i];
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
  last.fitted.fill(false);
  for (int m = 0; m < kBands; ++m) {
    if (!band_.set(CanvasBelief::kCutoffs[m], {times.data(), n}, {weights.data(), n})) return;
    for (int i = 0; i < kAxes; ++i) {
      for (std::size_t k = 0; k < n; ++k) x[k] = samples_[i][first + k].x;
      last.polynomials[m][i] = band_.predict({x.data(), n});
    }
  }
  last.fitted.fill(true);
}

void CanvasTracker::fit_repeated() noexcept {
  AxisPolynomial none;
  none.c.fill(std::nan(""));
  for (int i = 0; i < kAxes; ++i)
    entries_.back().polynomials[kBands][i] = RepeatedMotion::predict(samples_[i]).value_or(none);
}

void CanvasTracker::add(const CanvasFrame& frame) noexcept {
  Entry entry;
  if (!std::isfinite(frame.time) || !measure(frame, &entry)) return;
  if (!entries_.empty() && frame.time < entries_.back().time - kWindow) return;
  if (entries_.empty()) belief_.R_0 = entry.X_WK.R;
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
    entries_[at].polynomials = entries_[at - 1].polynomials;
    entries_[at].fitted = entries_[at - 1].fitted;
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
  fit_repeated();
  fit_waves();
  belief_.last = entries_.back();
  belief_.known = true;
  ++belief_.frames;
}

void CanvasTracker::restamp(double by) noexcept {
  for (Entry& e : entries_) {
    e.time += by;
    for (AxisWave& wave : e.waves) wave.origin += by;
    for (auto& model : e.polynomials)
      for (AxisPolynomial& axis : model) axis.origin += by;
  }
  if (!entries_.empty()) belief_.last = entries_.back();
}

double CanvasTracker::position_error() const noexcept {
  return std::sqrt(belief_.scores[0].blended + belief_.scores[1].blended +
                   belief_.scores[2].blended);
}

const char* CanvasTracker::model(int axis) const noexcept {
  if (entries_.empty()) return "none";
  const std::array<double, kModels> w = belief_.weights(belief_.last, axis);
  const auto most = std::max_element(w.begin(), w.end()) - w.begin();
  if (most == kSwinging) return "swinging";
  if (most == CanvasBelief::kRepeated) return "repeated";
  if (most >= kFilters) return "band";
  static constexpr const char* kNames[] = {"standing", "steady", "drifting"};
  if (most >= CanvasBelief::kPlain) return "smooth";
  return kNames[CanvasBelief::kBank[static_cast<std::size_t>(most)].order - 1];
}

}  // namespace impedraw

#include "impedraw/planning/path/axis_smoothing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>

#include "impedraw/common/angle.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

// One level is a factor kLevel of the smoothing. Level 0 smooths across corners, level -1 does not;
// levels between them mix both.
constexpr double kLevel = 1.5;
constexpr double kWithin = -1.0;
constexpr double kReach = 4.5;  // in standard deviations; the weight is below 4e-5 there
constexpr int kLevels = 6;      // up to 11 times the smoothing

class AxisSmoothing {
 public:
  AxisSmoothing(const std::vector<AxisKnot>& knots, double smoothing)
      : knots_(knots), smoothing_(smoothing) {
    within_.reserve(knots.size());
    across_.reserve(knots.size());
    for (std::size_t i = 0; i < knots.size(); ++i) {
      within_.push_back(within(i));
      across_.push_back(fitted(i, smoothing, 0, knots.size() - 1));
    }
  }

  const std::vector<Vector3d>& within() const { return within_; }  // level kWithin
  const std::vector<Vector3d>& across() const { return across_; }  // level 0

  Vector3d axis(std::size_t i, double level) const {
    if (level <= kWithin) return within_[i];
    if (level > 0.0) return fitted(i, width(level), 0, knots_.size() - 1);
    return level == 0.0 ? across_[i]
                        : (across_[i] + level * (across_[i] - within_[i])).normalized();
  }

  std::vector<Vector3d> at(const std::vector<double>& level) const {
    std::vector<Vector3d> axes;
    axes.reserve(knots_.size());
    for (std::size_t i = 0; i < knots_.size(); ++i) axes.push_back(axis(i, level[i]));
    return axes;
  }

  // By divided differences over the neighbouring knots, on the surface.
  bool keeps(const TiltLimits& limits, const std::vector<Vector3d>& n, std::size_t i) const {
    if (i == 0 || i + 1 == n.size() || knots_[i].corner) return true;
    const double h0 = (knots_[i].p - knots_[i - 1].p).norm(),
                 h2 = (knots_[i + 1].p - knots_[i].p).norm();
    if (!(h0 > 0.0) || !(h2 > 0.0)) return true;
    const Vector3d d0 = (n[i] - n[i - 1]) / h0, d2 = (n[i + 1] - n[i]) / h2;
    return std::max(d0.norm(), d2.norm()) <= limits.turn &&
           2.0 * (d2 - d0).norm() / (h0 + h2) <= limits.bend;
  }

  // The greatest level nearby, fading out over the length that its smoothing reaches: a step in
  // level would be a step in the axis.
  std::vector<double> spread(const std::vector<double>& level) const {
    std::vector<double> result = level;
    const auto fade = [&](std::size_t from, std::size_t to) {
      const double sigma = width(result[from]);
      const double step = std::abs(knots_[to].along - knots_[from].along);
      result[to] = std::max(result[to], result[from] - step / sigma);
    };
    for (std::size_t i = 1; i < result.size(); ++i) fade(i - 1, i);
    for (std::size_t i = result.size() - 1; i-- > 0;) fade(i + 1, i);
    return result;
  }

 private:
  double width(double level) const { return smoothing_ * std::pow(kLevel, std::max(0.0, level)); }

  Vector3d within(std::size_t i) const {
    const std::size_t last = knots_.size() - 1;
    std::size_t from = i, to = i;
    const auto inside = [&](std::size_t k) {
      const double distance = std::abs(knots_[k].along - knots_[i].along);
      return k == i || (!knots_[k].corner && distance < kReach * smoothing_);
    };
    while (from > 0 && inside(from)) --from;
    while (to < last && inside(to)) ++to;
    return knots_[i].corner
               ? (fitted(i, smoothing_, from, i) + fitted(i, smoothing_, i, to)).normalized()
               : fitted(i, smoothing_, from, to);
  }

  // Local parabola through the normals of the knots from `from` to `to`. It preserves normals that
  // turn at a constant or linearly changing rate, ends included. A straight line would cut the
  // crests of a sine by 0.1°.
  Vector3d fitted(std::size_t i, double sigma, std::size_t from, std::size_t to) const {
    const double s = knots_[i].along;
    if (!(sigma > 0.0)) return knots_[i].n;
    // Σ w xᵏ, of which Σ w b bᵀ consists, and Σ w b nᵀ, with b = (1, x, x²)
    double m0 = 0.0, m1 = 0.0, m2 = 0.0, m3 = 0.0, m4 = 0.0;
    Vector3d n0 = Vector3d::Zero(), n1 = n0, n2 = n0;
    int used = 0;
    const auto add = [&](std::size_t k) {
      const double x = (knots_[k].along - s) / sigma;
      if (std::abs(x) > kReach) return false;
      // The weight includes the distance to both neighbours, so that dense knots do not dominate.
      const double before = k > from ? knots_[k].along - knots_[k - 1].along : 0.0;
      const double after = k < to ? knots_[k + 1].along - knots_[k].along : 0.0;
      const double w = (before + after) / sigma * std::exp(-0.5 * x * x);
      const double wx = w * x, wxx = wx * x;
      m0 += w;
      m1 += wx;
      m2 += wxx;
      m3 += wxx * x;
      m4 += wxx * x * x;
      n0 += w * knots_[k].n;
      n1 += wx * knots_[k].n;
      n2 += wxx * knots_[k].n;
      ++used;
      return true;
    };
    for (std::size_t k = i; k <= to && add(k); ++k) {
    }
    for (std::size_t k = i; k-- > from && add(k);) {
    }
    Eigen::Matrix3d moments, normals;
    moments << m0, m1, m2, m1, m2, m3, m2, m3, m4;
    normals << n0.transpose(), n1.transpose(), n2.transpose();
    const Eigen::LDLT<Eigen::Matrix3d> factor(moments);
    if (used < 4 || !(factor.vectorD().minCoeff() > 1e-6 * factor.vectorD().maxCoeff()))
      return knots_[i].n;  // too few
    return Vector3d(factor.solve(normals).row(0)).normalized();
  }

  const std::vector<AxisKnot>& knots_;
  double smoothing_;
  std::vector<Vector3d> within_, across_;
};

}  // namespace

std::vector<Vector3d> smoothed_axes(const std::vector<AxisKnot>& knots, double smoothing,
                                    const TiltLimits& limits) {
  const std::size_t n = knots.size();
  const AxisSmoothing smoothed(knots, smoothing);
  if (!(smoothing > 0.0) || !(limits.allowance > 0.0) || n < 4) return smoothed.within();
  std::vector<double> level(n, kWithin);
  const std::vector<Vector3d>& base = smoothed.across();
  const auto leaves = [&](const std::vector<Vector3d>& axes, std::size_t i) {
    return level[i] > 0.0 && angle_between(axes[i], base[i]) > limits.allowance;
  };
  // Each knot takes the lowest level that keeps the limits there, unless that leaves the normal too
  // far.
  std::vector<char> done(n, 0);
  std::vector<Vector3d> axes = smoothed.within();
  for (double k = kWithin; k <= kLevels; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      // what `leaves` and `keeps` read
      const bool read = !done[i] || (i > 0 && !done[i - 1]) || (i + 1 < n && !done[i + 1]);
      if (read) axes[i] = smoothed.axis(i, k);
    }
    bool all = true;
    for (std::size_t i = 0; i < n; ++i) {
      if (done[i]) continue;
      const double before = level[i];
      level[i] = k;
      if (leaves(axes, i)) {
        level[i] = before;
        done[i] = 1;
        continue;
      }
      done[i] = smoothed.keeps(limits, axes, i);
      all = all && done[i];
    }
    if (all) break;
  }
  for (int round = 0; round < 4; ++round) {
    axes = smoothed.at(smoothed.spread(level));
    bool kept = true;
    for (std::size_t i = 0; i < n; ++i) {
      if (!leaves(axes, i)) continue;
      kept = false;
      level[i] = std::max(0.0, level[i] - 1.0);
    }
    if (kept) break;
  }
  return axes;
}

}  // namespace impedraw

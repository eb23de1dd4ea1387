#include "impedraw/planning/path/stroke_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <utility>

#include <fmt/core.h>
#include <Eigen/Cholesky>

#include "impedraw/common/errors.h"
#include "impedraw/common/rotations.h"
#include "impedraw/drawing/polyline.h"
#include "impedraw/planning/leant.h"

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

namespace {

using Eigen::Vector2d;
constexpr double kSamePoint = 1e-7;     // [m]
constexpr double kShortestSpan = 1e-6;  // [m]
constexpr int kMostRounds = 60;

struct FitLine {  // one part between corners, in the drawing plane and on the page
  std::vector<Vector2d> p_P, page;
  std::vector<double> place;  // of each vertex on the stroke (stroke_part.h) [m]
  std::vector<double> along;  // length up to each vertex [m]
};

struct FitKnot {
  double along;  // on the polyline [m]
  double place;  // on the stroke [m]
  Vector2d p, page;
  SurfaceSample sample;
};

class Fit {
 public:
  Fit(FitLine line, int stroke, const SurfaceHeight& surface, const FitSettings& settings,
      SurfaceHeight::Sample& last)
      : line_(std::move(line)),
        stroke_(stroke),
        surface_(surface),
        settings_(settings),
        last_(last) {
    line_.along.assign(1, 0.0);
    for (std::size_t i = 1; i < line_.p_P.size(); ++i) {
      line_.along.push_back(line_.along.back() + (line_.p_P[i] - line_.p_P[i - 1]).norm());
    }
    allowed_.assign(line_.p_P.size(), settings.tolerance);
    for (std::size_t i = 1; i + 1 < line_.p_P.size(); ++i) {
      const Vector2d before = line_.p_P[i] - line_.p_P[i - 1],
                     after = line_.p_P[i + 1] - line_.p_P[i];
      if (before.dot(after) < std::cos(kBend) * before.norm() * after.norm())
        allowed_[i] =
            std::max(settings.tolerance,
                     std::min(settings.rounding, std::min(before.norm(), after.norm()) / 40));
    }
  }

  // Places enough knots for the spline to stay on the line. Normals do not matter here.
  void find_knots() {
    // Start with vertices at least half a spacing apart. The loop below refines where that is too
    // coarse.
    const double total = line_.along.back();
    double last = -1;
    for (std::size_t i = 0; i + 1 < line_.p_P.size(); ++i) {
      const double s = line_.along[i];
      if (i > 0 &&
          (s - last < settings_.knot_spacing / 2 || total - s < settings_.knot_spacing / 4))
        continue;
      knots_.push_back(knot_at(s));
      last = s;
    }
    knots_.push_back(knot_at(total));

    PathSpline spline = through_knots();
    while (refine(spline)) spline = through_knots();
    if (insert_between(spline)) {
      spline = through_knots();
      while (refine(spline)) spline = through_knots();
    }
  }

  std::vector<FitKnot>& knots() { return knots_; }

  PathSpline through_knots() const {
    std::vector<SurfaceSample> samples;
    std::vector<double> along;
    samples.reserve(knots_.size());
    along.reserve(knots_.size());
    for (const FitKnot& k : knots_) {
      samples.push_back(k.sample);
      along.push_back(k.place);
    }
    return PathSpline(samples, along);
  }

 private:
  FitKnot knot_at(double s) const {
    const auto after = std::upper_bound(line_.along.begin() + 1, line_.along.end() - 1, s);
    const auto i = static_cast<std::size_t>(after - line_.along.begin());
    const double part =
        std::clamp((s - line_.along[i - 1]) / (line_.along[i] - line_.along[i - 1]), 0.0, 1.0);
    return sampled({s,
                    line_.place[i - 1] + part * (line_.place[i] - line_.place[i - 1]),
                    line_.p_P[i - 1] + part * (line_.p_P[i] - line_.p_P[i - 1]),
                    line_.page[i - 1] + part * (line_.page[i] - line_.page[i - 1]),
                    {}});
  }

  FitKnot sampled(FitKnot k) const {
    k.sample = sample_or_throw(surface_, k.p, k.page, stroke_, last_);
    return k;
  }

  static constexpr double kBend = 0.087;  // a vertex that turns less is part of a curve [rad]

  // The polyline's vertices from the one before s0 to the one after s1.
  std::pair<std::size_t, std::size_t> vertices(double s0, double s1) const {
    const auto& along = line_.along;
    auto first =
        static_cast<std::size_t>(std::upper_bound(along.begin(), along.end(), s0 + kSamePoint / 2) -
                                 along.begin()) -
        1;
    auto last = static_cast<std::size_t>(
        std::lower_bound(along.begin(), along.end(), s1 - kSamePoint / 2) - along.begin());
    last = std::min(last, along.size() - 1);
    return {std::min(first, last - 1), last};
  }

  bool keeps(const PathSpline& spline, std::size_t span) const {
    constexpr int kSamples = 8;
    const auto [first, last] = vertices(knots_[span].along, knots_[span + 1].along);
    const double allowed =  // simplification and sampling use the rest
        0.75 * *std::max_element(allowed_.begin() + static_cast<long>(first),
                                 allowed_.begin() + static_cast<long>(last) + 1);
    std::vector<Vector2d> curve;
    for (int i = 0; i <= kSamples; ++i) {
      curve.push_back(spline
                          .point(span, spline.start(span) +
                                           (spline.end(span) - spline.start(span)) * i / kSamples)
                          .head<2>());
      if (distance(curve.back(), line_.p_P, first, last) > allowed) return false;
    }
    for (std::size_t v = first + 1; v < last; ++v) {
      if (distance(line_.p_P[v], curve, 0, kSamples) > allowed) return false;
    }
    return true;
  }

  // Adds a knot in each span that exceeds the tolerance. Returns false if there is none.
  bool refine(const PathSpline& spline) {
    if (++rounds_ > kMostRounds) return false;
    std::vector<FitKnot> result;
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
      result.push_back(knots_[i]);
      const double s0 = knots_[i].along, s1 = knots_[i + 1].along;
      if (s1 - s0 < kShortestSpan || keeps(spline, i)) continue;
      const auto [first, last] = vertices(s0, s1);
      double s = (s0 + s1) / 2;
      if (last - first > 1) {  // the vertex nearest to the middle
        const auto nearer = [&](std::size_t a, std::size_t b) {
          return std::abs(line_.along[a] - s) < std::abs(line_.along[b] - s);
        };
        std::size_t best = first + 1;
        for (std::size_t v = first + 2; v < last; ++v) best = nearer(v, best) ? v : best;
        s = line_.along[best];
      }
      result.push_back(knot_at(s));
    }
    result.push_back(knots_.back());
    const bool grown = result.size() > knots_.size();
    knots_ = std::move(result);
    return grown;
  }

  // Adds knots on the spline itself where knots are far apart. They keep its shape seen along z and
  // follow the surface.
  bool insert_between(const PathSpline& spline) {
    std::vector<FitKnot> result;
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
      result.push_back(knots_[i]);
      const double u0 = spline.start(i), u1 = spline.end(i);
      const int pieces = static_cast<int>(std::ceil((u1 - u0) / settings_.knot_spacing - 1e-6));
      for (int k = 1; k < pieces; ++k) {
        FitKnot knot =
            knot_at(knots_[i].along + (knots_[i + 1].along - knots_[i].along) * k / pieces);
        knot.p = spline.point(i, u0 + (u1 - u0) * k / pieces).head<2>();
        result.push_back(sampled(knot));
      }
    }
    result.push_back(knots_.back());
    const bool grown = result.size() > knots_.size();
    knots_ = std::move(result);
    return grown;
  }

  FitLine line_;
  std::vector<double> allowed_;  // distance between spline and line, at each vertex [m]
  int stroke_;
  const SurfaceHeight& surface_;
  const FitSettings& settings_;
  SurfaceHeight::Sample& last_;  // found on the surface
  std::vector<FitKnot> knots_;
  int rounds_ = 0;
};

// At a corner both parts have the same axis. Returns the stroke's first and last axis.
std::pair<Vector3d, Vector3d> smooth_normals(const FitSettings& settings, std::vector<Fit>* fits) {
  std::vector<AxisKnot> all;
  std::vector<std::size_t> first;  // of each part; it is the last of the part before
  double start = 0.0;
  for (Fit& fit : *fits) {
    const std::vector<FitKnot>& knots = fit.knots();
    const std::size_t from = all.empty() ? 0 : 1;
    first.push_back(all.size() - from);
    for (std::size_t i = from; i < knots.size(); ++i)
      all.push_back({start + knots[i].along, knots[i].sample.p_P,
                     leant(knots[i].sample.n_P, settings.lean_deg), false});
    all.back().corner = true;
    start += knots.back().along;
  }
  all.back().corner = false;
  const std::vector<Vector3d> axes = smoothed_axes(all, settings.normal_smoothing, settings.tilt);
  for (std::size_t k = 0; k < fits->size(); ++k) {
    std::vector<FitKnot>& knots = (*fits)[k].knots();
    for (std::size_t i = 0; i < knots.size(); ++i) knots[i].sample.n_P = axes[first[k] + i];
  }
  return {axes.front(), axes.back()};
}

}  // namespace

FittedStroke fit_stroke(const PlacedStroke& stroke, const SurfaceHeight& surface,
                        const FitSettings& settings) {
  const int number = stroke.number;
  SurfaceHeight::Sample last;
  FitLine whole;
  double place = stroke.start;
  for (std::size_t i = 0; i < stroke.p_P.size(); ++i) {
    if (!stroke.p_P[i].allFinite())
      throw InputError(fmt::format("stroke {}: point {} is not a finite number", number, i));
    if (i > 0) place += (stroke.p_P[i] - stroke.p_P[i - 1]).norm();
    if (!whole.p_P.empty() && (stroke.p_P[i] - whole.p_P.back()).norm() < kSamePoint) continue;
    whole.place.push_back(place);
    whole.p_P.push_back(stroke.p_P[i]);
    whole.page.push_back(stroke.page[i]);
  }
  if (whole.p_P.empty()) throw InputError(fmt::format("stroke {}: has no points", number));

  FittedStroke fitted;
  fitted.to = stroke.start;
  fitted.first = fitted.last =
      sample_or_throw(surface, whole.p_P.front(), whole.page.front(), number, last);
  for (SurfaceSample* end : {&fitted.first, &fitted.last})
    end->n_P = leant(end->n_P, settings.lean_deg);
  if (whole.p_P.size() == 1) return fitted;

  FitLine line;
  for (std::size_t i : simplified(whole.p_P, settings.tolerance / 5)) {
    line.p_P.push_back(whole.p_P[i]);
    line.page.push_back(whole.page[i]);
    line.place.push_back(whole.place[i]);
  }
  if (line.p_P.size() == 2 && (line.p_P[1] - line.p_P[0]).norm() < kSamePoint)
    return fitted;  // both points coincide
  std::vector<std::size_t> cuts = corners(line.p_P, settings.corner_angle);
  cuts.push_back(line.p_P.size() - 1);
  std::size_t from = 0;
  std::vector<Fit> fits;
  for (std::size_t to : cuts) {
    FitLine part;
    part.p_P.assign(line.p_P.begin() + from, line.p_P.begin() + to + 1);
    part.page.assign(line.page.begin() + from, line.page.begin() + to + 1);
    part.place.assign(line.place.begin() + from, line.place.begin() + to + 1);
    Fit& fit = fits.emplace_back(std::move(part), number, surface, settings, last);
    fit.find_knots();
    from = to;
  }
  fitted.to = whole.place.back();
  fitted.last = sample_or_throw(surface, whole.p_P.back(), whole.page.back(), number, last);
  std::tie(fitted.first.n_P, fitted.last.n_P) = smooth_normals(settings, &fits);
  for (const Fit& fit : fits) fitted.parts.push_back(fit.through_knots());
  return fitted;
}

}  // namespace impedraw

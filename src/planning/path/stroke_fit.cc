#include "impedraw/planning/path/stroke_fit.h"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>
#include <Eigen/Cholesky>

#include "impedraw/common/angle.h"
#include "impedraw/common/errors.h"
#include "impedraw/drawing/polyline.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kSamePoint = 1e-7;     // [m]
constexpr double kShortestSpan = 1e-6;  // [m]
constexpr int kMostRounds = 60;

struct Line {  // one part between corners, in the drawing plane and on the page
  std::vector<Vector2d> p_P, page;
  std::vector<double> place;  // of each vertex on the stroke (stroke_part.h) [m]
  std::vector<double> along;  // length up to each vertex [m]
};

struct Knot {
  double along;  // on the polyline [m]
  double place;  // on the stroke [m]
  Vector2d p, page;
  SurfaceSample sample;
};

class Fit {
 public:
  Fit(Line line, int stroke, const SurfaceHeight& surface, const FitSettings& settings)
      : line_(std::move(line)), stroke_(stroke), surface_(surface), settings_(settings) {
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

  void smooth_normals() {
    const std::size_t n = knots_.size();
    const std::vector<Vector3d> base = smoothed_normals(std::vector<double>(n, 0.0));
    std::vector<Vector3d> axes = base;
    const TiltLimits& tilt = settings_.tilt;
    if (settings_.normal_smoothing > 0.0 && tilt.allowance > 0.0 && n >= 4) {
      // One level is a factor kLevel of the smoothing. Each knot takes the lowest level that keeps
      // the limits there, unless that leaves the normal too far.
      std::vector<double> level(n, 0.0);
      std::vector<char> done(n, 0);
      for (int k = 0; k <= kLevels; ++k) {
        const std::vector<Vector3d> trial =
            k == 0 ? base : smoothed_normals(std::vector<double>(n, k));
        bool all = true;
        for (std::size_t i = 0; i < n; ++i) {
          if (done[i]) continue;
          if (k > 0 && angle_between(trial[i], base[i]) > tilt.allowance) {
            done[i] = 1;
            continue;
          }
          level[i] = k;
          done[i] = keeps_tilt_limits(trial, i);
          all = all && done[i];
        }
        if (all) break;
      }
      if (*std::max_element(level.begin(), level.end()) > 0.0) {
        for (int round = 0; round < 4; ++round) {
          axes = smoothed_normals(spread(level));
          bool kept = true;
          for (std::size_t i = 0; i < n; ++i) {
            if (angle_between(axes[i], base[i]) <= tilt.allowance) continue;
            kept = false;
            level[i] = std::max(0.0, level[i] - 1.0);
          }
          if (kept) break;
        }
      }
    }
    for (std::size_t i = 0; i < n; ++i) knots_[i].sample.n_P = axes[i];
  }

  Eigen::Vector3d& first_normal() { return knots_.front().sample.n_P; }
  Eigen::Vector3d& last_normal() { return knots_.back().sample.n_P; }

  PathSpline through_knots() const {
    std::vector<SurfaceSample> samples;
    std::vector<double> along;
    samples.reserve(knots_.size());
    along.reserve(knots_.size());
    for (const Knot& k : knots_) {
      samples.push_back(k.sample);
      along.push_back(k.place);
    }
    return PathSpline(samples, along);
  }

 private:
  Knot knot_at(double s) const {
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

  Knot sampled(Knot k) const {
    k.sample = sample_or_throw(surface_, k.p, k.page, stroke_);
    return k;
  }

  static constexpr double kLevel = 1.5;
  static constexpr double kBend = 0.087;  // a vertex that turns less is part of a curve [rad]
  static constexpr int kLevels = 6;       // up to 11 times normal_smoothing

  // By divided differences over the neighbouring knots, on the surface.
  bool keeps_tilt_limits(const std::vector<Vector3d>& n, std::size_t i) const {
    if (i == 0 || i + 1 == n.size()) return true;
    const auto p = [this](std::size_t k) -> const Vector3d& { return knots_[k].sample.p_P; };
    const double h0 = (p(i) - p(i - 1)).norm(), h2 = (p(i + 1) - p(i)).norm();
    if (!(h0 > 0.0) || !(h2 > 0.0)) return true;
    const Vector3d d0 = (n[i] - n[i - 1]) / h0, d2 = (n[i + 1] - n[i]) / h2;
    return std::max(d0.norm(), d2.norm()) <= settings_.tilt.turn &&
           2.0 * (d2 - d0).norm() / (h0 + h2) <= settings_.tilt.bend;
  }

  // The greatest level nearby, fading out over the length that its smoothing reaches: a step in
  // level would be a step in the axis.
  std::vector<double> spread(const std::vector<double>& level) const {
    std::vector<double> result = level;
    const auto fade = [&](std::size_t from, std::size_t to) {
      const double sigma = settings_.normal_smoothing * std::pow(kLevel, result[from]);
      const double step = std::abs(knots_[to].along - knots_[from].along);
      result[to] = std::max(result[to], result[from] - step / sigma);
    };
    for (std::size_t i = 1; i < result.size(); ++i) fade(i - 1, i);
    for (std::size_t i = result.size() - 1; i-- > 0;) fade(i + 1, i);
    return result;
  }

  std::vector<Vector3d> smoothed_normals(const std::vector<double>& level) const {
    std::vector<Vector3d> normals;
    normals.reserve(knots_.size());
    for (std::size_t i = 0; i < knots_.size(); ++i)
      normals.push_back(
          smoothed_normal(i, settings_.normal_smoothing * std::pow(kLevel, level[i])));
    return normals;
  }

  // Local parabola through the normals with Gaussian weights. It preserves normals that turn at a
  // constant or linearly changing rate, ends included. A straight line would cut the crests of a
  // sine by 0.1°.
  Eigen::Vector3d smoothed_normal(std::size_t i, double sigma) const {
    const double s = knots_[i].along;
    if (!(sigma > 0.0)) return knots_[i].sample.n_P;
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero(),
                    normals = moments;  // Σ w b bᵀ, Σ w b nᵀ with b = (1, x, x²)
    int used = 0;
    const auto add = [&](std::size_t k) {
      const double x = (knots_[k].along - s) / sigma;
      if (std::abs(x) > 4.5) return false;  // the weight is below 4e-5: negligible
      // The weight includes the distance to both neighbours, so that dense knots do not dominate.
      const double before = k > 0 ? knots_[k].along - knots_[k - 1].along : 0.0;
      const double after = k + 1 < knots_.size() ? knots_[k + 1].along - knots_[k].along : 0.0;
      const double w = (before + after) / sigma * std::exp(-0.5 * x * x);
      const Eigen::Vector3d b(1.0, x, x * x);
      moments += w * b * b.transpose();
      normals += w * b * knots_[k].sample.n_P.transpose();
      ++used;
      return true;
    };
    for (std::size_t k = i; k < knots_.size() && add(k); ++k) {
    }
    for (std::size_t k = i; k-- > 0 && add(k);) {
    }
    const Eigen::LDLT<Eigen::Matrix3d> factor(moments);
    if (used < 4 || !(factor.vectorD().minCoeff() > 1e-6 * factor.vectorD().maxCoeff()))
      return knots_[i].sample.n_P;  // too few
    return Eigen::Vector3d(factor.solve(normals).row(0)).normalized();
  }

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
    std::vector<Knot> result;
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
    std::vector<Knot> result;
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
      result.push_back(knots_[i]);
      const double u0 = spline.start(i), u1 = spline.end(i);
      const int pieces = static_cast<int>(std::ceil((u1 - u0) / settings_.knot_spacing - 1e-6));
      for (int k = 1; k < pieces; ++k) {
        Knot knot = knot_at(knots_[i].along + (knots_[i + 1].along - knots_[i].along) * k / pieces);
        knot.p = spline.point(i, u0 + (u1 - u0) * k / pieces).head<2>();
        result.push_back(sampled(knot));
      }
    }
    result.push_back(knots_.back());
    const bool grown = result.size() > knots_.size();
    knots_ = std::move(result);
    return grown;
  }

  Line line_;
  std::vector<double> allowed_;  // distance between spline and line, at each vertex [m]
  int stroke_;
  const SurfaceHeight& surface_;
  const FitSettings& settings_;
  std::vector<Knot> knots_;
  int rounds_ = 0;
};

}  // namespace

FittedStroke fit_stroke(const PlacedStroke& stroke, const SurfaceHeight& surface,
                        const FitSettings& settings) {
  const int number = stroke.number;
  Line whole;
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
  fitted.number = number;
  fitted.from = fitted.to = stroke.start;
  fitted.first = fitted.last =
      sample_or_throw(surface, whole.p_P.front(), whole.page.front(), number);
  if (whole.p_P.size() == 1) return fitted;

  Line line;
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
    Line part;
    part.p_P.assign(line.p_P.begin() + from, line.p_P.begin() + to + 1);
    part.page.assign(line.page.begin() + from, line.page.begin() + to + 1);
    part.place.assign(line.place.begin() + from, line.place.begin() + to + 1);
    Fit& fit = fits.emplace_back(std::move(part), number, surface, settings);
    fit.find_knots();
    fit.smooth_normals();
    from = to;
  }
  fitted.to = whole.place.back();
  // At a corner both parts have the same normal.
  for (std::size_t i = 1; i < fits.size(); ++i) {
    const Eigen::Vector3d n = (fits[i - 1].last_normal() + fits[i].first_normal()).normalized();
    fits[i - 1].last_normal() = fits[i].first_normal() = n;
  }
  for (const Fit& fit : fits) fitted.parts.push_back(fit.through_knots());
  fitted.last = sample_or_throw(surface, whole.p_P.back(), whole.page.back(), number);
  fitted.first.n_P = fits.front().first_normal();
  fitted.last.n_P = fits.back().last_normal();
  return fitted;
}

}  // namespace impedraw

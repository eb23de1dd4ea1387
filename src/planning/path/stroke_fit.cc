#include "impedraw/planning/path/stroke_fit.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/polyline.h"
#include "impedraw/planning/leant.h"

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
  Fit(Line line, int stroke, const SurfaceHeight& surface, const FitSettings& settings,
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

  std::vector<Knot>& knots() { return knots_; }

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
  SurfaceHeight::Sample& last_;  // found on the surface
  std::vector<Knot> knots_;
  int rounds_ = 0;
};

// At a corner both parts have the same axis. Returns the stroke's first and last axis.
std::pair<Vector3d, Vector3d> smooth_normals(const FitSettings& settings, std::vector<Fit>* fits) {
  std::vector<AxisKnot> all;
  std::vector<std::size_t> first;  // of each part; it is the last of the part before
  double start = 0.0;
  for (Fit& fit : *fits) {
    const std::vector<Knot>& knots = fit.knots();
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
    std::vector<Knot>& knots = (*fits)[k].knots();
    for (std::size_t i = 0; i < knots.size(); ++i) knots[i].sample.n_P = axes[first[k] + i];
  }
  return {axes.front(), axes.back()};
}

}  // namespace

FittedStroke fit_stroke(const PlacedStroke& stroke, const SurfaceHeight& surface,
                        const FitSettings& settings) {
  const int number = stroke.number;
  SurfaceHeight::Sample last;
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
  fitted.to = stroke.start;
  fitted.first = fitted.last =
      sample_or_throw(surface, whole.p_P.front(), whole.page.front(), number, last);
  for (SurfaceSample* end : {&fitted.first, &fitted.last})
    end->n_P = leant(end->n_P, settings.lean_deg);
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

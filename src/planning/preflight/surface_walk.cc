#include "impedraw/planning/preflight/surface_walk.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// a height step that persists down to this width is a fold [m]
constexpr double kSharp = 1e-5;
// distance of ends from edges, so that rounding cannot put them on the other side [m]
constexpr double kRetreat = 1e-6;
// Beyond kSteep [rad] the heights kChord [m] to either side are looked at, too: beside a steep wall
// an estimated normal may lean less than the wall.
constexpr double kSteep = 1.0, kChord = 5e-4;
// the pen keeps off higher folds [m], by at most kFoldMargin [m]
constexpr double kRidden = 1e-3, kFoldMargin = 4e-3;
// A run of points is one segment up to surface_step, if its chord is this share of it at least: it
// is off by at most 0.02 of its length.
constexpr double kStraight = 0.999;

struct Look {
  double along = 0;
  Vector2d at = Vector2d::Zero();
  std::optional<SurfaceSample> sample;
  std::optional<Problem> problem;
  double slope = 0;  // [rad]
};

class Walk {
 public:
  Walk(const SurfaceHeight& surface, const PreflightSettings& settings)
      : surface_(surface), settings_(settings) {}

  std::vector<SurfaceSpan> along(const PlacedStroke& stroke) {
    double from = stroke.start;
    Look last = look(from, stroke.p_P.front());
    open(last, from);
    for (std::size_t i = 1; i < stroke.p_P.size(); ++i) {
      const Vector2d a = stroke.p_P[i - 1];
      double length = (stroke.p_P[i] - a).norm();
      if (length == 0) continue;
      for (; i + 1 < stroke.p_P.size(); ++i) {
        const Vector2d next = stroke.p_P[i + 1];
        const double further = length + (next - stroke.p_P[i]).norm();
        if (further > settings_.surface_step || (next - a).norm() < kStraight * further) break;
        length = further;
      }
      const Vector2d b = stroke.p_P[i];
      const int pieces = static_cast<int>(std::ceil(length / settings_.surface_step));
      for (int k = 1; k <= pieces; ++k) {
        const double share = static_cast<double>(k) / pieces;
        const Look next = look(from + share * length, a + share * (b - a));
        advance(last, next);
        last = next;
      }
      from += length;
    }
    retreat();
    std::optional<StrokeRuler> ruler;
    for (std::size_t i = 0; i < spans_.size(); ++i) {
      if (spans_[i].problem == Problem::off_canvas)
        measure_off(i, ruler ? *ruler : ruler.emplace(stroke));
    }
    return std::move(spans_);
  }

 private:
  Look look(double along, const Vector2d& at) {
    Look look{along, at, surface_(at.x(), at.y(), found_), {}, 0};
    if (!look.sample) {
      look.problem = Problem::off_canvas;
      return look;
    }
    look.slope =
        std::acos(std::clamp(std::min(look.sample->n_P.z(), look.sample->steepest), -1.0, 1.0));
    if (look.slope > kSteep) look.slope = std::max(look.slope, chord_slope(*look.sample));
    if (look.slope > settings_.max_slope_deg * std::numbers::pi / 180)
      look.problem = Problem::too_steep;
    return look;
  }

  // Slope of the heights on either side of a place, up and down [rad]; 0 where they are unknown.
  double chord_slope(const SurfaceSample& at) {
    const Vector2d uphill = -kChord * at.n_P.head<2>().normalized();
    const Vector2d up = at.p_P.head<2>() + uphill, down = at.p_P.head<2>() - uphill;
    const auto above = surface_(up.x(), up.y(), found_),
               below = surface_(down.x(), down.y(), found_);
    if (!above || !below) return 0.0;
    return std::atan2(std::abs(above->p_P.z() - below->p_P.z()), 2.0 * kChord);
  }

  // Height difference between l and r that neither the slopes at both nor a bend in between
  // explains [m].
  static double step_in_height(const Look& l, const Look& r) {
    const Vector2d way = r.at - l.at;
    const auto rise = [&way](const SurfaceSample& s) {
      return -way.dot(s.n_P.head<2>()) / s.n_P.z();
    };
    const double before = rise(*l.sample), after = rise(*r.sample);
    return std::abs(r.sample->p_P.z() - l.sample->p_P.z() - (before + after) / 2) -
           std::abs(after - before) / 2;
  }

  void advance(const Look& l, const Look& r) {
    const bool same = l.problem == r.problem;
    const double finest = same ? kSharp : settings_.edge_tolerance;
    const bool stepped = same && !l.problem && step_in_height(l, r) > settings_.fold_height / 4;
    if (same && !stepped) return extend(r);
    if (r.along - l.along > finest) {
      const Look middle = look((l.along + r.along) / 2, (l.at + r.at) / 2);
      advance(l, middle);
      advance(middle, r);
    } else if (same) {
      if (step_in_height(l, r) > settings_.fold_height)
        fold(l, r);
      else
        extend(r);
    } else if (l.sample && r.sample && step_in_height(l, r) > settings_.fold_height) {
      // a wall that is too steep, and the ground at its foot
      spans_.back().to = l.along;
      fold(l, r);
    } else {
      const double boundary = l.problem ? r.along : l.along;
      spans_.back().to = boundary;
      open(r, boundary);
    }
  }

  void fold(const Look& l, const Look& r) {
    SurfaceSpan span;
    span.from = span.worst = l.along;
    span.to = r.along;
    span.problem = Problem::fold;
    span.p_P = r.sample->p_P;
    span.step = std::abs(r.sample->p_P.z() - l.sample->p_P.z());
    const double rise = r.sample->p_P.z() - l.sample->p_P.z();
    span.text = fmt::format("the surface {} by {:.1f} mm", rise > 0 ? "rises" : "drops",
                            1e3 * std::abs(rise));
    spans_.push_back(std::move(span));
    open(r, r.along);
  }

  void open(const Look& first, double from) {
    SurfaceSpan span;
    span.from = from;
    span.problem = first.problem;
    spans_.push_back(std::move(span));
    extend(first);
  }

  void extend(const Look& next) {
    SurfaceSpan& span = spans_.back();
    span.to = next.along;
    if (!next.problem) {
      span.along.push_back(next.along);
      span.samples.push_back(*next.sample);
    } else if (next.sample && next.slope >= span.slope) {
      span.worst = next.along;
      span.p_P = next.sample->p_P;
      span.text = fmt::format("slope {:.0f}°, allowed {:.0f}°", next.slope * 180 / std::numbers::pi,
                              settings_.max_slope_deg);
    }
    span.slope = std::max(span.slope, next.slope);
  }

  // Moves the ends of drawable spans, except the stroke's own, away from where the surface changes:
  // by a tiny distance, by edge_margin where the surface ends or is too steep, and at a fold by as
  // much as it is high, up to kFoldMargin, so that the pen neither falls off it nor runs up.
  // Shorter spans are rejected.
  void retreat() {
    for (std::size_t i = 0; i < spans_.size(); ++i) {
      SurfaceSpan& span = spans_[i];
      if (span.problem || span.along.size() < 2) continue;
      const auto distance = [&](std::size_t neighbour) {
        const SurfaceSpan& other = spans_[neighbour];
        if (other.problem == Problem::off_canvas || other.problem == Problem::too_steep)
          return std::max(kRetreat, settings_.edge_margin);
        if (other.problem == Problem::fold && other.step > kRidden)
          return std::max(kRetreat, std::min(other.step, kFoldMargin));
        return kRetreat;
      };
      const double from = i > 0 ? span.from + distance(i - 1) : span.from;
      const double to = i + 1 < spans_.size() ? span.to - distance(i + 1) : span.to;
      if (to - from < kRetreat) {
        span.problem = Problem::too_short;
        span.worst = (span.from + span.to) / 2;
        span.p_P = span.samples[span.samples.size() / 2].p_P;
        span.text = fmt::format("{:.2f} mm are left within {:.1f} mm of the canvas's edges",
                                1e3 * (span.to - span.from), 1e3 * settings_.edge_margin);
        continue;
      }
      if (i > 0) spans_[i - 1].to = from;
      if (i + 1 < spans_.size()) spans_[i + 1].from = to;
      trim(span, from, to);
    }
  }

  // Keeps only the span's samples between the two positions and interpolates its ends.
  static void trim(SurfaceSpan& span, double from, double to) {
    const auto at = [&span](double along) {
      const auto after = std::upper_bound(span.along.begin(), span.along.end(), along);
      const auto next = std::clamp<std::size_t>(
          static_cast<std::size_t>(after - span.along.begin()), 1, span.along.size() - 1);
      const double share =
          (along - span.along[next - 1]) / (span.along[next] - span.along[next - 1]);
      const SurfaceSample &a = span.samples[next - 1], &b = span.samples[next];
      return SurfaceSample{a.p_P + share * (b.p_P - a.p_P),
                           ((1 - share) * a.n_P + share * b.n_P).normalized()};
    };
    std::vector<double> along{from};
    std::vector<SurfaceSample> samples{at(from)};
    for (std::size_t k = 0; k < span.along.size(); ++k) {
      if (span.along[k] <= from || span.along[k] >= to) continue;
      along.push_back(span.along[k]);
      samples.push_back(span.samples[k]);
    }
    along.push_back(to);
    samples.push_back(at(to));
    span.from = from;
    span.to = to;
    span.along = std::move(along);
    span.samples = std::move(samples);
  }

  void measure_off(std::size_t i, const StrokeRuler& stroke) {
    SurfaceSpan& span = spans_[i];
    const bool enters = i > 0, leaves = i + 1 < spans_.size();
    std::vector<double> places;  // candidates for the farthest point
    if (!enters) places.push_back(span.from);
    if (!leaves) places.push_back(span.to);
    if (enters == leaves) places.push_back((span.from + span.to) / 2);
    double z = 0;
    if (enters && !spans_[i - 1].samples.empty())
      z = spans_[i - 1].samples.back().p_P.z();
    else if (leaves && !spans_[i + 1].samples.empty())
      z = spans_[i + 1].samples.front().p_P.z();
    double farthest = -1;
    for (double place : places) {
      const Vector2d at = stroke.at(place).p_P;
      const std::optional<double> off = distance_off(surface_, at, kSearched);
      const double by = off.value_or(2 * kSearched);
      if (by <= farthest) continue;
      farthest = by;
      span.worst = place;
      span.p_P << at, z;
      span.text =
          fmt::format("{} mm off the canvas", off ? fmt::format("{:.1f}", 1e3 * by)
                                                  : fmt::format("over {:.0f}", 1e3 * kSearched));
      if (!off) break;
    }
  }

  static constexpr double kSearched = 0.5;  // [m]

  const SurfaceHeight& surface_;
  const PreflightSettings& settings_;
  SurfaceHeight::Sample found_;  // last
  std::vector<SurfaceSpan> spans_;
};

}  // namespace

std::vector<SurfaceSpan> walk_surface(const PlacedStroke& stroke, const SurfaceHeight& surface,
                                      const PreflightSettings& settings) {
  return Walk(surface, settings).along(stroke);
}

SurfaceProfile::SurfaceProfile(const SurfaceSpan& span, double smoothing)
    : span_(span), smoothing_(smoothing) {
  integral_.assign(span.along.size(), Vector3d::Zero());
  for (std::size_t i = 1; i < integral_.size(); ++i) {
    integral_[i] = integral_[i - 1] + (span.along[i] - span.along[i - 1]) / 2 *
                                          (span.samples[i - 1].n_P + span.samples[i].n_P);
  }
}

std::size_t SurfaceProfile::interval(double along) const {
  const auto after =
      std::upper_bound(span_.along.begin(), span_.along.end(), along) - span_.along.begin();
  return std::clamp<std::size_t>(after, 1, span_.along.size() - 1);
}

Vector3d SurfaceProfile::normal_integral(double along) const {
  const std::size_t i = interval(along);
  const double h = span_.along[i] - span_.along[i - 1], x = along - span_.along[i - 1];
  const Vector3d before = span_.samples[i - 1].n_P, after = span_.samples[i].n_P;
  return integral_[i - 1] + x * before + x * x / (2 * h) * (after - before);
}

SurfaceSample SurfaceProfile::at(double along) const {
  if (span_.along.size() == 1) return span_.samples.front();
  along = std::clamp(along, span_.along.front(), span_.along.back());
  const std::size_t i = interval(along);
  const double share = (along - span_.along[i - 1]) / (span_.along[i] - span_.along[i - 1]);
  const SurfaceSample &a = span_.samples[i - 1], &b = span_.samples[i];
  // A window cut at an end of the span is cut on the other side too. Otherwise its mean would
  // belong to another position.
  const double half =
      std::min({smoothing_ / 2, along - span_.along.front(), span_.along.back() - along});
  Vector3d n = (1 - share) * a.n_P + share * b.n_P;
  if (half > 1e-9) n = normal_integral(along + half) - normal_integral(along - half);
  return {a.p_P + share * (b.p_P - a.p_P), n.normalized()};
}

}  // namespace impedraw

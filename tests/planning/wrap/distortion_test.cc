// Distortion against closed forms, and what the wrap gains over the projection.
#include "impedraw/planning/wrap/distortion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "impedraw/planning/wrap/wrap.h"
#include "wrap_surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using surfaces::circle;
using surfaces::line;
const Vector2d kCentre(0.60, 0);

void print(const char* name, const Distortion& d) {
  fmt::print(
      "{:26} stretch {:.4f} to {:.4f}, rms {:.4f}; area {:.4f} to {:.4f}; angle {:.2f}°; {:.3f} "
      "m\n",
      name, d.stretch_min, d.stretch_max, d.stretch_rms, d.area_min, d.area_max,
      d.angle_max * 180 / std::numbers::pi, d.page_length);
}

// Over a patch: stretch in all directions at its vertices, weighted by page area. No chart: of the
// projection.
Distortion over_patch(const SurfacePatch& patch, const FlatChart* chart) {
  Distortion d;
  d.stretch_min = d.area_min = INFINITY;
  d.stretch_max = d.area_max = 0.0;
  double squares = 0.0, weights = 0.0;
  for (const SurfaceSample& sample : patch.samples) {
    const LocalStretch s = chart ? stretch_of_wrap(sample, *chart) : stretch_of_projection(sample);
    const double weight = chart ? chart->differential(sample.p_P.head<2>()).determinant() : 1.0;
    d.stretch_min = std::min(d.stretch_min, s.smallest);
    d.stretch_max = std::max(d.stretch_max, s.largest);
    d.area_min = std::min(d.area_min, s.area());
    d.area_max = std::max(d.area_max, s.area());
    d.angle_max = std::max(d.angle_max, s.angle());
    for (const double stretch : {s.smallest, s.largest}) {
      squares += weight * (stretch - 1) * (stretch - 1);
      weights += weight;
    }
  }
  d.stretch_rms = std::sqrt(squares / weights);
  return d;
}

TEST(Distortion, OfATiltedPlaneIsThatOfItsSlope) {
  const double slope = 30 * std::numbers::pi / 180, s = 1 / std::cos(slope);
  const SurfaceHeight surface =
      surfaces::height_field([&](double x, double) { return std::tan(slope) * x; });
  const PlacedStroke up = line({kCentre, kCentre + Vector2d(0.05, 0)}),
                     across = line({kCentre, kCentre + Vector2d(0, 0.15)});
  const Distortion d = distortion_of_projection({up, across}, surface);
  EXPECT_NEAR(d.stretch_max, s, 1e-9);
  EXPECT_NEAR(d.stretch_min, 1, 1e-9);
  EXPECT_NEAR(d.stretch_rms, (s - 1) * std::sqrt(0.05 / 0.20), 1e-9);
  EXPECT_NEAR(d.area_min, s, 1e-9);
  EXPECT_NEAR(d.area_max, s, 1e-9);
  EXPECT_NEAR(d.angle_max, 2 * std::asin((s - 1) / (s + 1)), 1e-9);
  EXPECT_NEAR(d.page_length, 0.20, 1e-12);

  const Wrap wrap(surface, kCentre, {up, across});
  for (const Distortion& w : {distortion_of_wrap({up, across}, surface, wrap.chart()),
                              over_patch(wrap.chart().patch(), &wrap.chart())}) {
    EXPECT_NEAR(w.stretch_min, 1, 1e-8);
    EXPECT_NEAR(w.stretch_max, 1, 1e-8);
    EXPECT_LT(w.stretch_rms, 1e-8);
    EXPECT_NEAR(w.area_max, 1, 1e-8);
    EXPECT_LT(w.angle_max, 1e-8);
  }
  const Distortion patch = over_patch(wrap.chart().patch(), nullptr);
  EXPECT_NEAR(patch.stretch_rms, (s - 1) / std::sqrt(2), 1e-9);
  EXPECT_NEAR(patch.stretch_min, 1, 1e-9);
  EXPECT_NEAR(patch.stretch_max, s, 1e-9);
}

// The two directions that stretch most and least, as told, against chords on the surface in many
// directions.
TEST(Distortion, SingularValuesAreTheExtremesOverDirections) {
  const Wrap wrap(surfaces::waves, kCentre, {circle(kCentre, 0.08)});
  const double d = 1e-5;
  for (const Vector2d& flat :
       {Vector2d(0.63, 0.02), Vector2d(0.57, -0.045), Vector2d(0.61, 0.05)}) {
    const Vector2d plane = *wrap.to_plane(flat);
    const LocalStretch wrapped =
        stretch_of_wrap(*surfaces::waves(plane.x(), plane.y()), wrap.chart());
    const LocalStretch projected = stretch_of_projection(*surfaces::waves(flat.x(), flat.y()));
    double least = 9, most = 0, least_projected = 9, most_projected = 0;
    for (int k = 0; k < 720; ++k) {
      const Vector2d step =
          d * Vector2d(std::cos(k * std::numbers::pi / 720), std::sin(k * std::numbers::pi / 720));
      const Vector2d a = *wrap.to_plane(flat - step), b = *wrap.to_plane(flat + step);
      const double stretch =
          (surfaces::waves(b.x(), b.y())->p_P - surfaces::waves(a.x(), a.y())->p_P).norm() /
          (2 * d);
      least = std::min(least, stretch);
      most = std::max(most, stretch);
      const Vector2d p = flat - step, q = flat + step;
      const double direct =
          (surfaces::waves(q.x(), q.y())->p_P - surfaces::waves(p.x(), p.y())->p_P).norm() /
          (2 * d);
      least_projected = std::min(least_projected, direct);
      most_projected = std::max(most_projected, direct);
    }
    EXPECT_NEAR(wrapped.largest, most, 1e-5);
    EXPECT_NEAR(wrapped.smallest, least, 1e-5);
    EXPECT_NEAR(projected.largest, most_projected, 1e-5);
    EXPECT_NEAR(projected.smallest, least_projected, 1e-5);
    EXPECT_GT(most_projected, 1.02) << "nothing to tell apart";
  }
}

TEST(Distortion, OfAMeridianOfTheBowlIsItsSecant) {
  const double R = surfaces::kBowlRadius, r = 0.15;
  const Distortion d =
      distortion_of_projection({line({kCentre, kCentre + Vector2d(r, 0)})}, surfaces::bowl);
  // ∫ (sec φ − 1)² dr over the stroke, r = R sin φ.
  double squares = 0;
  const int n = 20000;
  for (int i = 0; i < n; ++i)
    squares += std::pow(1 / std::sqrt(1 - std::pow((i + 0.5) / n * r / R, 2)) - 1, 2) / n;
  EXPECT_NEAR(d.stretch_rms, std::sqrt(squares), 1e-5);
  EXPECT_NEAR(d.stretch_max, 1 / std::sqrt(1 - r * r / (R * R)), 1e-3);
  EXPECT_NEAR(d.stretch_min, 1, 1e-5);
}

TEST(Distortion, TheWrapStretchesTheBowlFarLess) {
  const std::vector<PlacedStroke> strokes = {circle(kCentre, 0.14), circle(kCentre, 0.07),
                                             line({{0.46, 0}, {0.74, 0}}),
                                             line({{0.6, -0.14}, {0.6, 0.14}})};
  const Wrap wrap(surfaces::bowl, kCentre, strokes);
  const Distortion projected = distortion_of_projection(strokes, surfaces::bowl);
  const Distortion wrapped = distortion_of_wrap(strokes, surfaces::bowl, wrap.chart());
  const Distortion patch_projected = over_patch(wrap.chart().patch(), nullptr);
  const Distortion patch_wrapped = over_patch(wrap.chart().patch(), &wrap.chart());
  print("strokes, projected", projected);
  print("strokes, wrapped", wrapped);
  print("patch, projected", patch_projected);
  print("patch, wrapped", patch_wrapped);
  EXPECT_LT(wrapped.stretch_rms, 0.7 * projected.stretch_rms);
  EXPECT_LT(patch_wrapped.stretch_rms, 0.25 * patch_projected.stretch_rms);
  EXPECT_LT(patch_wrapped.angle_max, 0.5 * patch_projected.angle_max);
  // Gauss: a sphere cannot be laid flat. Equal areas would need stretches apart, equal angles areas
  // apart.
  EXPECT_GT(patch_wrapped.stretch_max - patch_wrapped.stretch_min, 0.02);
  EXPECT_GT(patch_wrapped.stretch_min, 0.93);
  EXPECT_LT(patch_wrapped.stretch_max, 1.07);
  EXPECT_NEAR(wrapped.page_length, projected.page_length, 1e-9);
}

}  // namespace
}  // namespace impedraw

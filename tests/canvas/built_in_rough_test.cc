// Built-in rough canvases against their formulas: the slopes and lengths that were asked for.
#include "impedraw/canvas/built_in.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/canvas.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

RoughSettings rough(RoughForm form, double slope_deg, double wavelength, int seed = 1) {
  RoughSettings s;
  s.footprint.centre = Vector3d::Zero();
  s.form = form;
  s.slope_deg = slope_deg;
  s.wavelength = wavelength;
  s.seed = seed;
  return s;
}

// Root mean square, over the area as seen from above, of tan of the facets' slope.
double rms_slope(const TriangleMesh& mesh) {
  double squares = 0.0, area = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3d n = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                           .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    const double seen = std::abs(n.z());
    squares += seen * n.head<2>().squaredNorm() / (n.z() * n.z());
    area += seen;
  }
  return std::sqrt(squares / area);
}

TEST(Rough, FractalHasItsSlopeAndNoShorterWave) {
  for (const auto& [slope, length] : {std::pair{10.0, 0.015}, {30.0, 0.008}}) {
    SCOPED_TRACE(length);
    double squares = 0.0;
    constexpr int kSeeds = 4;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      const double rms = rms_slope(make_rough(rough(RoughForm::fractal, slope, length, seed)));
      squares += rms * rms / kSeeds;
    }
    // Chords of a quarter of the shortest wave lose a tenth of its slope.
    EXPECT_NEAR(std::sqrt(squares) / std::tan(slope * kPi / 180), 1.0, 0.08);

    // The power of the profile through the middle, by a Fourier sum with Hann's window.
    const TriangleMesh mesh = make_rough(rough(RoughForm::fractal, slope, length));
    std::map<double, double> profile;
    double nearest = 1.0;
    for (const Vector3d& p : mesh.vertices) nearest = std::min(nearest, std::abs(p.y()));
    for (const Vector3d& p : mesh.vertices)
      if (p.y() >= 0.0 && p.y() < nearest + 1e-9) profile[p.x()] = p.z();
    ASSERT_GT(profile.size(), 100u);
    double mean = 0.0;
    for (const auto& [x, z] : profile) mean += z / static_cast<double>(profile.size());
    const double width = profile.rbegin()->first - profile.begin()->first;
    // of slopes: each wave's power times k²
    double longer = 0.0, shorter = 0.0, shortest_third = 0.0;
    for (int m = 1; m * length < 2.5 * width; ++m) {
      std::complex<double> sum = 0.0;
      for (const auto& [x, z] : profile) {
        const double share = (x - profile.begin()->first) / width;
        sum += (1.0 - std::cos(2.0 * kPi * share)) * (z - mean) *
               std::polar(1.0, -2.0 * kPi * m * share);
      }
      const double wave = width / m, power = std::norm(sum) * m * m;
      (wave > 0.9 * length ? longer : shorter) += power;
      if (wave > 0.95 * length && wave < 2.0 * length) shortest_third += power;
    }
    EXPECT_LT(shorter, 1e-3 * longer);
    EXPECT_GT(shortest_third, 0.02 * longer) << "waves down to the length asked for";
  }
}

TEST(Rough, FacetsAreFlatTrianglesOfTheirSideAndSlope) {
  double squares = 0.0;
  constexpr int kSeeds = 5;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const TriangleMesh mesh = make_rough(rough(RoughForm::facets, 20.0, 0.010, seed));
    EXPECT_EQ(mesh.triangles.size(), 2u * 30 * 30);
    for (const Eigen::Vector3i& t : mesh.triangles) {
      double shortest = 1.0;
      for (int i = 0; i < 3; ++i)
        shortest = std::min(shortest,
                            (mesh.vertices[t[i]] - mesh.vertices[t[(i + 1) % 3]]).head<2>().norm());
      ASSERT_NEAR(shortest, 0.010, 1e-9);
    }
    const double rms = rms_slope(mesh);
    squares += rms * rms / kSeeds;
  }
  EXPECT_NEAR(std::sqrt(squares) / std::tan(20.0 * kPi / 180), 1.0, 0.05);
}

// z = s times the distance to the next line x = i λ.
TEST(Rough, RidgesAreAZigzag) {
  const double length = 0.020, s = std::tan(25.0 * kPi / 180);
  const TriangleMesh mesh = make_rough(rough(RoughForm::ridges, 25.0, length));
  double highest = 0.0;
  for (const Vector3d& p : mesh.vertices) {
    ASSERT_NEAR(p.z(), s * std::abs(std::remainder(p.x(), length)), 1e-12);
    highest = std::max(highest, p.z());
  }
  EXPECT_NEAR(highest, s * length / 2, s * 1e-3);
  EXPECT_NEAR(rms_slope(mesh) / s, 1.0, 0.1);
}

TEST(Rough, RippleIsASineAlongACylinder) {
  const double length = 0.015, s = std::tan(15.0 * kPi / 180), R = RoughSettings::kRippleRadius;
  const TriangleMesh mesh = make_rough(rough(RoughForm::ripple, 15.0, length));
  double squares = 0.0;
  for (const Vector3d& p : mesh.vertices) {
    const double k = 2 * kPi / length;
    ASSERT_NEAR(p.z(),
                std::sqrt(R * R - p.y() * p.y()) - R + std::sqrt(2.0) * s / k * std::sin(k * p.x()),
                1e-12);
    const double along = std::sqrt(2.0) * s * std::cos(k * p.x());
    squares += along * along / static_cast<double>(mesh.vertices.size());
  }
  EXPECT_NEAR(std::sqrt(squares), s, 0.01 * s);
}

// Height of the topmost sheet; NaN without one.
double top(const Canvas& canvas, double x, double y) {
  const auto hit = canvas.ray({x, y, 1.0}, {0, 0, -1});
  return hit ? hit->p_W.z() : std::nan("");
}

TEST(Rough, AStepIsAWallOfItsHeight) {
  RoughSettings s = rough(RoughForm::step, 0.0, 0.015);
  s.height = 0.007;
  const Canvas canvas(make_rough(s));
  for (double y = -0.14; y <= 0.14; y += 0.0137) {
    for (double x = -0.14; x < -RoughSettings::kWall; x += 0.0031)
      ASSERT_EQ(top(canvas, x, y), 0.0);
    EXPECT_NEAR(top(canvas, -1.05 * RoughSettings::kWall, y), 0.0, 1e-9);
    EXPECT_NEAR(top(canvas, -0.5 * RoughSettings::kWall, y), 0.5 * s.height, 0.01 * s.height);
    for (double x = 1e-6; x < 0.14; x += 0.0031) ASSERT_NEAR(top(canvas, x, y), s.height, 1e-12);
  }
}

TEST(Rough, AHoleIsRoundAndAsWideAsAsked) {
  const double diameter = 0.020;
  const RoughSettings s = rough(RoughForm::hole, 0.0, diameter);
  const Canvas canvas(make_rough(s));
  const double cell = s.footprint.edge;
  int missing = 0, looks = 0;
  for (double x = -0.03; x <= 0.03; x += 0.0005)
    for (double y = -0.03; y <= 0.03; y += 0.0005) {
      const double r = std::hypot(x, y);
      const bool gone = std::isnan(top(canvas, x, y));
      ++looks, missing += gone;
      if (std::abs(r - diameter / 2) > cell) {
        ASSERT_EQ(gone, r < diameter / 2) << x << ' ' << y;
      }
    }
  const double area = 0.06 * 0.06 * missing / looks;
  EXPECT_NEAR(area / (kPi * diameter * diameter / 4), 1.0, 0.05);
}

TEST(Rough, ALipIsASecondSheet) {
  RoughSettings s = rough(RoughForm::lip, 0.0, 0.015);
  s.height = 0.010;
  const Canvas canvas(make_rough(s));
  for (double y = -0.14; y <= 0.14; y += 0.017)
    for (double x = -0.14; x <= 0.14; x += 0.017) {
      EXPECT_NEAR(top(canvas, x, y), x > 0.0 ? s.height : 0.0, 1e-12);
      const auto below = canvas.ray({x, y, -1.0}, {0, 0, 1});
      ASSERT_TRUE(below);
      EXPECT_NEAR(below->p_W.z(), 0.0, 1e-12);
    }
}

}  // namespace
}  // namespace impedraw

#include "impedraw/planning/path/path_spline.h"

#include <random>

#include <gtest/gtest.h>

#include "planning/surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

TEST(PathSpline, CircleOnTheBowl) {
  std::vector<SurfaceSample> knots;
  for (int i = 0; i <= 600; ++i)
    knots.push_back(*surfaces::bowl(0.60 + 0.1 * std::cos(i * 0.01), 0.1 * std::sin(i * 0.01)));
  const PathSpline spline(knots);
  EXPECT_NEAR(spline.arc_length(), 0.6, 1e-8);
  for (double u = 0; u <= spline.length(); u += 1.234e-3) {
    const SplinePoint s = spline.at(u);
    EXPECT_NEAR((s.p - Vector3d(0.60, 0, s.p.z())).norm(), 0.1, 1e-9);
    EXPECT_NEAR(s.dp.norm(), 1, 5e-5);
    EXPECT_NEAR(s.ddp.norm(), 10, 0.02);  // 1/r
    EXPECT_NEAR(s.n.cross((surfaces::kBowlCentre - s.p).normalized()).norm(), 0, 1e-7);
    EXPECT_NEAR(s.n.cross(s.dn).norm(), 1 / surfaces::kBowlRadius,
                1e-4);  // the normal turns as the sphere does
  }
}

TEST(PathSpline, StraightLinesStayStraight) {
  std::vector<SurfaceSample> knots;
  for (double x : {0.0, 0.1, 0.1001, 0.15, 0.4})
    knots.push_back({{x, 2 * x, 0.5}, Vector3d::UnitZ()});
  const PathSpline spline(knots);
  for (double u = 0; u <= spline.length(); u += 1e-3) {
    const SplinePoint s = spline.at(u);
    EXPECT_NEAR(s.p.y(), 2 * s.p.x(), 1e-14);
    EXPECT_LT(s.ddp.norm(), 1e-9);
    EXPECT_NEAR(s.p.x(), u / std::sqrt(5.0), 1e-12);
  }
}

TEST(PathSpline, DerivativesAreThose) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> any;
    std::vector<SurfaceSample> knots;
    for (int i = 0; i < 2 + static_cast<int>(seed); ++i) {
      const Vector3d p(i * 0.01 + 0.002 * any(random), 0.003 * any(random), 0.003 * any(random));
      knots.push_back({p, Vector3d(0.3 * any(random), 0.3 * any(random), 1).normalized()});
    }
    const PathSpline spline(knots);
    const double h = 1e-6;
    for (double u = 2 * h; u < spline.length() - 2 * h; u += spline.length() / 97) {
      const SplinePoint s = spline.at(u), a = spline.at(u - h), b = spline.at(u + h);
      EXPECT_NEAR(s.n.norm(), 1, 1e-14);
      EXPECT_LT(((b.p - a.p) / (2 * h) - s.dp).norm(), 1e-6);
      EXPECT_LT(((b.dp - a.dp) / (2 * h) - s.ddp).norm(), 1e-4 * (1 + s.ddp.norm()) + 0.2);
      EXPECT_LT(((b.n - a.n) / (2 * h) - s.dn).norm(), 1e-4 * (1 + s.dn.norm()));
      EXPECT_LT(((b.dn - a.dn) / (2 * h) - s.ddn).norm(), 1e-4 * (1 + s.ddn.norm()) + 20);
    }
    for (std::size_t i = 0; i < spline.spans(); ++i)
      EXPECT_LT((spline.at(spline.start(i)).p - knots[i].p_P).norm(), 1e-14);
    // The bounds hold inside each span.
    for (std::size_t i = 0; i < spline.spans(); ++i) {
      const PathSpline::Bounds bounds = spline.bounds(i);
      for (int k = 0; k <= 50; ++k) {
        EXPECT_LE(
            spline.at(spline.start(i) + (spline.end(i) - spline.start(i)) * k / 50).ddp.norm(),
            bounds.bend * (1 + 1e-12));
      }
    }
  }
}

}  // namespace
}  // namespace impedraw

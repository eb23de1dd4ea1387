#include "impedraw/planning/target.h"

#include <numbers>

#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "planning/surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(Target, BuiltInsLieOnTheirFormulaAndTheCanvas) {
  for (const std::string& name : shape_names()) {
    SCOPED_TRACE(name);
    const Artwork artwork = make_shape(name).target();
    const TargetLine line =
        project_target(placed_strokes(artwork, place(artwork, shape_placement())), surfaces::bowl);
    ASSERT_EQ(line.points.size(), line.stroke.size());
    double gap = 0, off = 0;
    for (std::size_t i = 0; i < line.points.size(); ++i) {
      const Vector3d& p = line.points[i];
      EXPECT_NEAR((p - surfaces::kBowlCentre).norm(), surfaces::kBowlRadius, 1e-12);
      if (name == "circle") {
        EXPECT_NEAR((p - Vector3d(0.60, 0.0, p.z())).norm(), 0.06, 1e-6);
      } else if (name != "M") {
        EXPECT_NEAR(p.x(), 0.60 + 0.05 * std::sin(2 * std::numbers::pi * (p.y() + 0.15) / 0.15),
                    1e-6);
      }
      if (i == 0) continue;
      gap = std::max(gap, (p - line.points[i - 1]).norm());
      off = std::max(off, surfaces::kBowlRadius -
                              ((p + line.points[i - 1]) / 2 - surfaces::kBowlCentre).norm());
    }
    EXPECT_LE(gap, 5e-4);
    EXPECT_LE(off, 1e-5);
  }
}

TEST(Target, FollowsWavesBetweenFarPoints) {
  const TargetLine line = project_target(
      {surfaces::line({{0.5, -0.1}, {0.7, 0.1}}), surfaces::line({{0.6, 0}}, 1)}, surfaces::waves);
  EXPECT_EQ(line.stroke.front(), 0);
  EXPECT_EQ(line.stroke.back(), 1);
  for (std::size_t i = 1; i + 1 < line.points.size(); ++i) {
    const Vector3d middle = (line.points[i] + line.points[i - 1]) / 2;
    EXPECT_LE((line.points[i] - line.points[i - 1]).norm(), 5e-4);
    EXPECT_NEAR(middle.z(), surfaces::waves(middle.x(), middle.y())->p_P.z(), 1e-5);
  }
}

TEST(Target, AStepOfTheCanvasEnds) {
  const auto step = [](double x, double y) {
    return std::optional(SurfaceSample{{x, y, x < 0.6 ? 0.1 : 0.2}, Vector3d::UnitZ()});
  };
  EXPECT_LT(project_target({surfaces::line({{0.5, 0}, {0.7, 0}})}, step).points.size(), 1000u);
}

// Beside a steep wall the nearest sheet of an estimated surface may change back and forth.
TEST(Target, AStepThatFlickersCountsFewTimes) {
  const SurfaceHeight flickers = [](double x, double y) {
    const double hash = std::sin(1e9 * x) * 43758.5453;
    const bool upper = std::abs(x - 0.6) < 5e-6 ? hash - std::floor(hash) < 0.5 : x > 0.6;
    return SurfaceSample{{x, y, upper ? 0.105 : 0.1}, Vector3d::UnitZ()};
  };
  const TargetLine line = project_target({surfaces::line({{0.5, 0}, {0.7, 0}})}, flickers);
  double length = 0.0;
  for (std::size_t i = 1; i < line.points.size(); ++i)
    length += (line.points[i] - line.points[i - 1]).norm();
  EXPECT_LT(length, 0.2 + 5 * 0.005);
}

TEST(Target, LeavingTheCanvasIsAnError) {
  EXPECT_THROW(project_target({surfaces::line({{0.6, 0}, {0.6, 0.2}})}, surfaces::bowl),
               InputError);
}

// An estimated surface is rough at any scale: the number of points stays bounded.
TEST(Target, RoughnessBelowTheSpacingIsNotFollowedForEver) {
  const SurfaceHeight rough = [](double x, double y) {
    const double hash = std::sin(1e9 * x + 3e8 * y) * 43758.5453;
    return SurfaceSample{{x, y, 2e-5 * (hash - std::floor(hash))}, Eigen::Vector3d::UnitZ()};
  };
  const TargetSettings settings;
  const TargetLine line = project_target({surfaces::line({{0, 0}, {0.1, 0}})}, rough, settings);
  EXPECT_LT(line.points.size(), 60 * 0.1 / (settings.spacing / 2));
}

}  // namespace
}  // namespace impedraw

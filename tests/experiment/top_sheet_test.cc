// The lid over a surface ends where a sheet above it does.
#include "impedraw/experiment/top_sheet.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

constexpr double kVoxel = 4e-3, kHeight = 0.1, kRadius = 0.04;  // [m]

// A table, and a ball above it, by a point in each voxel.
std::vector<Eigen::Vector3d> ball_over_table(std::mt19937* random) {
  std::uniform_real_distribution<double> within(-0.5 * kVoxel, 0.5 * kVoxel);
  std::vector<Eigen::Vector3d> points;
  for (double x = -0.08; x <= 0.08; x += kVoxel)
    for (double y = -0.08; y <= 0.08; y += kVoxel)
      points.emplace_back(x + within(*random), y + within(*random), 0.0);
  for (double polar = 0.0; polar <= 2.0; polar += kVoxel / kRadius)
    for (double turn = 0.0; turn < 6.28;
         turn += kVoxel / (kRadius * std::max(0.1, std::sin(polar))))
      points.emplace_back(kRadius * std::sin(polar) * std::cos(turn),
                          kRadius * std::sin(polar) * std::sin(turn),
                          kHeight + kRadius * std::cos(polar));
  return points;
}

TEST(TopSheet, EndsWhereTheSheetDoes) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  const TopSheet sheet(ball_over_table(&random));
  std::uniform_real_distribution<double> side(-0.07, 0.07);
  int beside = 0;
  for (int i = 0; i < 2000; ++i) {
    const double x = side(random), y = side(random), off = std::hypot(x, y) - kRadius;
    SCOPED_TRACE(off);
    if (off < -1e-3) EXPECT_GT(sheet.lid(x, y), kHeight - 0.02);
    if (off > 2.5e-3) EXPECT_LT(std::abs(sheet.lid(x, y)), 1e-12);
    beside += off > 2.5e-3 && sheet.top(x, y) > 0.05;
  }
  EXPECT_GT(beside, 50);  // the cells of `top` tell less
  EXPECT_FALSE(std::isfinite(sheet.lid(0.2, 0.0)));
  EXPECT_FALSE(std::isfinite(TopSheet({}).lid(0.0, 0.0)));
}

}  // namespace
}  // namespace impedraw

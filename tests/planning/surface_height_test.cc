#include "impedraw/planning/surface_height.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Sample = SurfaceHeight::Sample;

// A plane that ends where `off` is positive, the distance from it; counts how often it is asked.
template <class Off>
SurfaceHeight bounded(const Off& off, int* looks = nullptr) {
  return [off, looks](double x, double y) -> Sample {
    if (looks) ++*looks;
    if (off(Vector2d(x, y)) > 0.0) return std::nullopt;
    return SurfaceSample{{x, y, 0.0}, Eigen::Vector3d::UnitZ()};
  };
}

// Against the closed form: a half-plane in any direction, a disc seen from outside and inside.
TEST(SurfaceHeight, TheDistanceToTheEdgeIsTheShortest) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(0.0, 6.28), how_far(1e-3, 0.08);
  for (int i = 0; i < 40; ++i) {
    const double a = angle(random), d = how_far(random);
    const Vector2d out(std::cos(a), std::sin(a));
    const auto half = [&](const Vector2d& p) { return out.dot(p) + d; };
    const auto disc = [&](const Vector2d& p) { return (p - (d + 0.03) * out).norm() - 0.03; };
    const auto hole = [&](const Vector2d& p) { return d - p.norm(); };
    int looks = 0;
    for (const SurfaceHeight& surface :
         {bounded(half, &looks), bounded(disc, &looks), bounded(hole, &looks)}) {
      looks = 0;
      const std::optional<double> found = distance_off(surface, Vector2d::Zero());
      ASSERT_TRUE(found);
      EXPECT_GT(*found, d - 2e-6);
      EXPECT_LT(*found, 1.02 * d + 1.2e-4);
      EXPECT_LT(looks, 36 * (d / 5e-3 + 1) + 100);
    }
  }
  EXPECT_FALSE(distance_off([](double, double) { return Sample(); }, Vector2d::Zero(), 0.05));
}

// Two sheets, the upper one over x > 0: the last answer says which is meant.
TEST(SurfaceHeight, OneWhoAsksAlongALineStaysOnItsSheet) {
  const SurfaceHeight sheets = [](double x, double y, Sample& last) -> Sample {
    const bool lower = x <= 0.0 || (last && last->p_P.z() < 0.5);
    return last = SurfaceSample{{x, y, lower ? 0.0 : 1.0}, Eigen::Vector3d::UnitZ()};
  };
  EXPECT_EQ(sheets(0.1, 0.0)->p_P.z(), 1.0);
  Sample last;
  for (const double x : {-0.1, 0.0, 0.1}) EXPECT_EQ(sheets(x, 0.0, last)->p_P.z(), 0.0);
  EXPECT_EQ(sheets(0.1, 0.0)->p_P.z(), 1.0);
}

}  // namespace
}  // namespace impedraw

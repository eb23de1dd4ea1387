// The normal that a measured force tells, against forces of a known normal and Coulomb friction.
#include "impedraw/control/felt_normal.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kDt = 1e-3, kFriction = 0.3;

FeltNormalSettings half() {
  FeltNormalSettings s;
  s.share = 0.5;
  return s;
}

FeltNormal felt(const FeltNormalSettings& settings, const Vector3d& n, const Vector3d& f,
                const Vector3d& slip) {
  FeltNormal normal(settings, kDt);
  for (int i = 0; i < 100; ++i) normal.update(n, f, slip, kFriction, 1.0);
  return normal;
}

// A random normal and a direction of slip across it.
struct Stroke {
  Vector3d n, slip;
};
Stroke random_stroke(std::mt19937& rng) {
  std::normal_distribution<double> normal;
  const Vector3d n = Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
  return {n, n.cross(Vector3d(normal(rng), normal(rng), normal(rng))).normalized()};
}

TEST(FeltNormal, ASurfaceThatLeansToTheSideIsFeltBesideFriction) {
  const FeltNormalSettings s = half();
  const unsigned seed = 1;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> angle(0.2, 0.7), friction(0.0, kFriction), force(2.0, 9.0);
  for (int i = 0; i < 100; ++i) {
    const Stroke stroke = random_stroke(rng);
    const double lean = angle(rng), f_n = force(rng);
    const Vector3d n_true = Eigen::AngleAxisd(lean, stroke.slip) * stroke.n;
    const Vector3d f = f_n * (n_true - friction(rng) * std::cos(lean) * stroke.slip);
    const FeltNormal normal = felt(s, stroke.n, f, stroke.slip);
    const Vector3d seen = normal.seen_from(stroke.n), law = normal.corrected(stroke.n);
    const double beyond =
        std::tan(lean) -
        std::min(std::tan(lean), s.deviation + s.force_error / (f_n * std::cos(lean)));
    EXPECT_NEAR(std::acos(std::min(1.0, seen.dot(stroke.n))), std::atan(beyond), 1e-6);
    EXPECT_NEAR(std::acos(std::min(1.0, law.dot(stroke.n))), std::atan(s.share * beyond), 1e-6);
    EXPECT_NEAR(seen.dot(stroke.slip), 0.0, 1e-9);
    EXPECT_GE(seen.dot(n_true), stroke.n.dot(n_true));
  }
}

TEST(FeltNormal, NeitherFrictionNorASmallErrorChangesTheNormal) {
  const unsigned seed = 2;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> friction(0.0, kFriction), share(-1.0, 1.0);
  for (int i = 0; i < 100; ++i) {
    const Stroke stroke = random_stroke(rng);
    const Vector3d side = stroke.n.cross(stroke.slip);
    for (const double f_n : {1.0, 5.0}) {
      const double most = 0.1 * f_n + 0.25;
      const Vector3d f =
          f_n * stroke.n - friction(rng) * f_n * stroke.slip + 0.99 * most * share(rng) * side;
      const FeltNormal normal = felt(half(), stroke.n, f, stroke.slip);
      EXPECT_LT((normal.seen_from(stroke.n) - stroke.n).norm(), 1e-12);
      EXPECT_LT((normal.corrected(stroke.n) - stroke.n).norm(), 1e-12);
    }
  }
}

// The spring may hold the tip aside against friction: that is no slope.
TEST(FeltNormal, ATipAtRestFeelsNoSlope) {
  const Vector3d n = Vector3d::UnitZ();
  const FeltNormal normal = felt(half(), n, {4.0, 0.0, 5.0}, Vector3d::Zero());
  EXPECT_LT((normal.seen_from(n) - n).norm(), 1e-12);
}

TEST(FeltNormal, OfAWallNoMoreThanHalfARightAngleIsBelieved) {
  const Vector3d n = Vector3d::UnitZ();
  const FeltNormal normal = felt(half(), n, {0.0, 50.0, 5.0}, Vector3d::UnitX());
  EXPECT_NEAR(normal.seen_from(n).dot(n), std::sqrt(0.5), 1e-9);
}

TEST(FeltNormal, IsForgottenWithTheContactAndUnusedWithoutAShare) {
  const Vector3d n = Vector3d::UnitZ(), f(0.0, 3.0, 5.0), slip = Vector3d::UnitX();
  FeltNormal normal = felt(half(), n, f, slip);
  EXPECT_GT((normal.seen_from(n) - n).norm(), 0.1);
  normal.reset();
  EXPECT_EQ(normal.seen_from(n), n);
  EXPECT_EQ(felt({}, n, f, slip).seen_from(n), n);
}

TEST(FeltNormal, FollowsWithinItsTime) {
  FeltNormalSettings s;
  s.share = 1.0;
  s.deviation = s.force_error = 0.0;
  FeltNormal normal(s, kDt);
  const Vector3d n = Vector3d::UnitZ();
  for (int i = 1; i <= 15; ++i) {
    normal.update(n, {0.0, 0.05, 5.0}, Vector3d::UnitX(), kFriction, 1.0);
    ASSERT_NEAR(normal.seen_from(n).y(), 0.01 * (1.0 - std::pow(1.0 - kDt / 5e-3, i)), 1e-6);
  }
}

}  // namespace
}  // namespace impedraw

#include "impedraw/planning/path/speed_profile.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "seeds.h"

namespace impedraw {
namespace {

TEST(SpeedProfile, TrapezoidAndTriangleInClosedForm) {
  const SpeedProfile trapezoid({{1.0, 0.2, 1.0}}, 0);
  EXPECT_NEAR(trapezoid.duration(), 1.0 / 0.2 + 0.2 / 1.0, 1e-12);
  EXPECT_NEAR(trapezoid.at(0.1).x, 0.005, 1e-12);
  EXPECT_NEAR(trapezoid.at(0.1).speed, 0.1, 1e-12);
  EXPECT_NEAR(trapezoid.at(3).speed, 0.2, 1e-12);
  const SpeedProfile triangle({{0.01, 0.2, 1.0}}, 0);
  EXPECT_NEAR(triangle.duration(), 2 * std::sqrt(0.01), 1e-12);
  EXPECT_NEAR(triangle.at(0.1).speed, 0.1, 1e-12);
  // Smoothed, it ends that much later and has gone as far.
  const SpeedProfile smooth({{1.0, 0.2, 1.0}}, 0.04);
  EXPECT_NEAR(smooth.duration(), trapezoid.duration() + 0.04, 1e-12);
  EXPECT_NEAR(smooth.at(100).x, 1.0, 1e-12);
  EXPECT_NEAR(smooth.at(0.04).acceleration, 1.0, 1e-12);
  EXPECT_NEAR(smooth.at(0.02).acceleration, 0.5, 1e-12);
}

TEST(SpeedProfile, ManySpansOfOneLimitAreOneSpan) {
  const SpeedProfile one({{0.5, 0.05, 1}}, 0.04),
      many(std::vector<SpeedSpan>(1000, {0.0005, 0.05, 1}), 0.04);
  EXPECT_NEAR(one.duration(), many.duration(), 1e-10);
  for (double t = 0; t < one.duration(); t += 0.0137) EXPECT_NEAR(one.at(t).x, many.at(t).x, 1e-10);
}

// The form that stores nothing has the same values, bit by bit.
TEST(SpeedProfile, OneSpanNeedsNoStore) {
  for (const SpeedSpan span : {SpeedSpan{1.0, 0.2, 1.0}, SpeedSpan{0.001, 0.2, 1.0}, SpeedSpan{}}) {
    for (const double T : {0.0, 0.04}) {
      const SpeedProfile stored({span}, T);
      EXPECT_EQ(rest_to_rest_duration(span, T), stored.duration());
      for (double t = -0.01; t < stored.duration() + 0.02; t += 0.0037) {
        const SpeedState a = stored.at(t), b = rest_to_rest(span, T, t);
        EXPECT_EQ(a.x, b.x);
        EXPECT_EQ(a.speed, b.speed);
        EXPECT_EQ(a.acceleration, b.acceleration);
      }
    }
  }
}

TEST(SpeedProfile, RandomSpansKeepTheirLimitsAndTheirDerivatives) {
  for (unsigned seed = 0; seed < seeds(200, 5000); ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0, 1);
    std::vector<SpeedSpan> spans;
    const int count = 1 + static_cast<int>(60 * any(random));
    double highest_acceleration = 0, length = 0;
    for (int i = 0; i < count; ++i) {
      spans.push_back(
          {std::pow(10.0, -5 + 3 * any(random)), 0.005 + 0.1 * any(random), 0.3 + any(random)});
      highest_acceleration = std::max(highest_acceleration, spans.back().acceleration);
      length += spans.back().length;
    }
    const double T = 0.03;
    const SpeedProfile profile(spans, T);
    EXPECT_NEAR(profile.length(), length, 1e-12);
    const double h = 1e-5, step = profile.duration() / 1500;
    double end = spans[0].length;
    std::size_t in = 0;
    for (double t = 0; t < profile.duration(); t += step) {
      const SpeedState s = profile.at(t), before = profile.at(t - h), after = profile.at(t + h);
      while (s.x > end && in + 1 < spans.size()) end += spans[++in].length;
      ASSERT_GE(s.speed, -1e-12);
      ASSERT_LE(s.speed, spans[in].speed + 1e-9);
      ASSERT_LE(std::abs(s.acceleration), spans[in].acceleration + 1e-9);
      ASSERT_NEAR((after.x - before.x) / (2 * h), s.speed, 1e-7);
      ASSERT_NEAR((after.speed - before.speed) / (2 * h), s.acceleration,
                  2 * highest_acceleration / T * h + 1e-7);
    }
    EXPECT_NEAR(profile.at(profile.duration() - 1e-6).x, length, 1e-9);
    EXPECT_NEAR(profile.at(profile.duration() - 1e-6).speed, 0, 1e-6);
  }
}

TEST(SpeedProfile, NoFasterProfileExistsBeforeSmoothing) {
  // At every instant the profile is at the span's speed, or at its full acceleration.
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(0, 1);
  std::vector<SpeedSpan> spans;
  for (int i = 0; i < 50; ++i) spans.push_back({0.002, 0.02 + 0.1 * any(random), 0.5});
  const SpeedProfile profile(spans, 0);
  for (double t = 1e-4; t < profile.duration(); t += 1e-3) {
    const SpeedState s = profile.at(t);
    const double limit =
        spans[std::min<std::size_t>(static_cast<std::size_t>(s.x / 0.002), 49)].speed;
    EXPECT_TRUE(std::abs(s.acceleration) > 0.499 || s.speed > limit - 1e-9) << t;
  }
}

TEST(SpeedProfile, NoLengthTakesNoTime) {
  EXPECT_EQ(SpeedProfile().duration(), 0);
  EXPECT_EQ(SpeedProfile({{0, 1, 1}}, 0.1).duration(), 0);
  EXPECT_EQ(SpeedProfile().at(1).x, 0);
}

}  // namespace
}  // namespace impedraw

// Forecasts of a conveyor that moves by steps, against its true motion.
#include "impedraw/perception/repeated_motion.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "impedraw/common/minimum_jerk.h"

namespace impedraw {
namespace {

constexpr double kSigma = 1e-4, kMove = 0.5, kWay = 0.03;  // [m], [s], [m]

// Steps of kWay within kMove, rests of uneven length; the third and fourth step lead back.
class Conveyor {
 public:
  explicit Conveyor(unsigned seed) : random_(seed) {
    std::uniform_real_distribution<double> rest(0.7, 1.1);
    for (double t = rest(random_); t < 30.0; t += kMove + rest(random_)) starts_.push_back(t);
  }
  double at(double t) const {
    double x = 0.0;
    for (std::size_t k = 0; k < starts_.size(); ++k)
      x += (k % 4 < 2 ? kWay : -kWay) *
           MinimumJerk::at(std::clamp((t - starts_[k]) / kMove, 0.0, 1.0), kMove).share;
    return x;
  }
  // As frames show it, up to `until`.
  std::vector<AxisSample> seen(double until) {
    std::normal_distribution<double> noise(0.0, kSigma);
    std::vector<AxisSample> samples;
    for (double t = until - 6.0; t <= until; t += 1.0 / 30.0)
      samples.push_back({t, at(t) + noise(random_), kSigma * kSigma});
    return samples;
  }
  const std::vector<double>& starts() const { return starts_; }

 private:
  std::mt19937 random_;
  std::vector<double> starts_;
};

// 70 ms before a step ends: a motion that goes on as it does there would be 3 mm too far.
TEST(RepeatedMotion, ForeseesWhereAStepEnds) {
  constexpr double kAhead = 0.07;  // [s]
  Conveyor conveyor(1);
  double square = 0.0, unforeseen = 0.0, count = 0.0;
  for (const double start : conveyor.starts())
    for (double into = 0.2; into < kMove; into += 0.03) {
      const double now = start + into;
      if (now < 7.0) continue;
      const auto found = RepeatedMotion::predict(conveyor.seen(now));
      ASSERT_TRUE(found);
      const double speed = (conveyor.at(now + 1e-4) - conveyor.at(now - 1e-4)) / 2e-4;
      square += std::pow(found->at(now + kAhead).x - conveyor.at(now + kAhead), 2);
      unforeseen += std::pow(conveyor.at(now) + speed * kAhead - conveyor.at(now + kAhead), 2);
      count += 1.0;
    }
  EXPECT_LT(std::sqrt(square / count), 0.3e-3);
  EXPECT_GT(std::sqrt(unforeseen / count), 1e-3);
}

TEST(RepeatedMotion, RestsWhileTheConveyorRests) {
  Conveyor conveyor(2);
  for (const double start : conveyor.starts()) {
    const double now = start + kMove + 0.35;
    if (now < 7.0) continue;
    const auto found = RepeatedMotion::predict(conveyor.seen(now));
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->at(now + 0.08).x, conveyor.at(now), 0.3e-3) << now;
  }
}

TEST(RepeatedMotion, IsNoneOfWhatStandsOrWasSeenForTooShort) {
  Conveyor conveyor(3);
  std::vector<AxisSample> samples = conveyor.seen(10.0);
  samples.resize(20);
  EXPECT_FALSE(RepeatedMotion::predict(samples));
  samples = conveyor.seen(10.0);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].x = kSigma * std::sin(7.0 * i);
  EXPECT_FALSE(RepeatedMotion::predict(samples));
}

}  // namespace
}  // namespace impedraw

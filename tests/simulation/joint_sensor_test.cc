// The sensor's faults, one at a time, by their definitions.
#include "impedraw/simulation/joint_sensor.h"

#include <cmath>

#include <gtest/gtest.h>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

constexpr double kDt = 1e-3;

JointVector ramp(int i) { return JointVector::Constant(2, 0.4 * i * kDt + 0.1); }
JointVector speed() { return JointVector::Constant(2, 0.4); }

TEST(JointSensor, WithoutFaultsReadsTheState) {
  JointSensorSettings settings;
  EXPECT_TRUE(settings.exact());
  JointSensor sensor(settings, 2, kDt, 1);
  for (int i = 0; i < 10; ++i) {
    const JointReading& read = sensor.sample(ramp(i), speed());
    EXPECT_EQ(read.q, ramp(i));
    EXPECT_EQ(read.v, speed());
  }
}

TEST(JointSensor, RoundsToTheQuantum) {
  JointSensorSettings settings;
  settings.quantum = 1e-3;
  EXPECT_FALSE(settings.exact());
  JointSensor sensor(settings, 2, kDt, 1);
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const JointVector q = sensor.sample(ramp(i), speed()).q;
    EXPECT_NEAR(q[0] / 1e-3, std::round(q[0] / 1e-3), 1e-9);
    worst = std::max(worst, (q - ramp(i)).cwiseAbs().maxCoeff());
  }
  EXPECT_LE(worst, 0.5e-3 + 1e-12);
  EXPECT_GT(worst, 0.4e-3);
}

TEST(JointSensor, AddsNoiseOfTheSdAskedForAndTheSameForASeed) {
  JointSensorSettings settings;
  settings.position_noise = 1e-4;
  settings.velocity_noise = 5e-3;
  JointSensor sensor(settings, 2, kDt, 7), same(settings, 2, kDt, 7), other(settings, 2, kDt, 8);
  const int samples = 100000;
  double q_square = 0.0, v_square = 0.0, lagged = 0.0, last = 0.0;
  for (int i = 0; i < samples; ++i) {
    const JointReading read = sensor.sample(ramp(0), speed());
    ASSERT_EQ(read.v, same.sample(ramp(0), speed()).v);
    ASSERT_NE(read.v, other.sample(ramp(0), speed()).v);
    const double q = (read.q - ramp(0))[0], v = (read.v - speed())[1];
    q_square += q * q / samples;
    v_square += v * v / samples;
    lagged += v * last / samples;
    last = v;
  }
  EXPECT_NEAR(std::sqrt(q_square), 1e-4, 2e-6);
  EXPECT_NEAR(std::sqrt(v_square), 5e-3, 1e-4);
  EXPECT_LT(std::abs(lagged), 0.02 * 25e-6) << "white";
}

TEST(JointSensor, IsLate) {
  JointSensorSettings settings;
  settings.delay = 3e-3;
  JointSensor sensor(settings, 2, kDt, 1);
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(sensor.sample(ramp(i), i * speed()).q, ramp(std::max(0, i - 3)));
  EXPECT_EQ(settings.velocity_age(kDt), 3e-3);
}

// A ramp that begins at rest: the filter's step response, 1 − exp(−ω t).
TEST(JointSensor, DifferencesAndFilters) {
  JointSensorSettings settings;
  settings.velocity = VelocityReading::difference;
  settings.velocity_bandwidth = 200.0;
  JointSensor sensor(settings, 2, kDt, 1);
  for (int i = 0; i < 100; ++i) {
    const JointVector v = sensor.sample(ramp(i), speed()).v;
    EXPECT_NEAR(v[0], 0.4 * (1.0 - std::exp(-200.0 * i * kDt)), 1e-9);
  }
  EXPECT_NEAR(settings.velocity_age(kDt), 5.5e-3, 1e-12);
  settings.velocity_bandwidth = 0.0;
  JointSensor plain(settings, 2, kDt, 1);
  plain.sample(ramp(0), speed());
  EXPECT_NEAR(plain.sample(ramp(1), speed()).v[0], 0.4, 1e-9);
}

TEST(JointSensor, MayGiveNoVelocity) {
  JointSensorSettings settings;
  settings.velocity = VelocityReading::none;
  settings.velocity_noise = 1.0;
  JointSensor sensor(settings, 2, kDt, 1);
  EXPECT_EQ(sensor.sample(ramp(3), speed()).v, JointVector(JointVector::Zero(2)));
}

TEST(JointSensor, RefusesWhatCannotBe) {
  JointSensorSettings negative, late;
  negative.quantum = -1.0;
  late.delay = 1.0;
  EXPECT_THROW(JointSensor(negative, 2, kDt, 1), InputError);
  EXPECT_THROW(JointSensor(late, 2, kDt, 1), InputError);
}

}  // namespace
}  // namespace impedraw

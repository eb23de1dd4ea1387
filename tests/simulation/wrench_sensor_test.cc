// The sensor's errors, one at a time and together, against their definitions.
#include "impedraw/simulation/wrench_sensor.h"

#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

Vector6 some_wrench() {
  Vector6 F;
  F << 1.0, -2.0, 3.0, 0.1, -0.2, 0.3;
  return F;
}

TEST(WrenchSensor, WithoutFaultsReadsTheWrench) {
  WrenchSensor sensor({}, 1e-3, 1);
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(sensor.sample(i * some_wrench()), Vector6(i * some_wrench()));
  EXPECT_FALSE(sensor.saturated());
}

// G, read off by unit wrenches.
TEST(WrenchSensor, GainAndCrossTalkHaveTheirSizesAndSignsFromTheSeed) {
  WrenchSensorSettings settings;
  settings.gain_error = 0.01;
  settings.cross_talk = 0.02;
  const auto gain = [&](std::uint64_t seed) {
    WrenchSensor sensor(settings, 1e-3, seed);
    Matrix6 G;
    for (int i = 0; i < 6; ++i) G.col(i) = sensor.sample(Vector6::Unit(i));
    return G;
  };
  const Matrix6 G = gain(1);
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(std::abs(G(i, i) - 1.0), 0.01, 1e-12);
    Vector6 others = G.row(i);
    others[i] = 0.0;
    others.tail<3>() *= i < 3 ? 0.1 : 1.0;  // 10 N as 1 Nm
    others.head<3>() *= i < 3 ? 1.0 : 10.0;
    EXPECT_NEAR(others.norm(), 0.02, 1e-12);
  }
  EXPECT_EQ(G, gain(1));
  EXPECT_GT((G - gain(2)).norm(), 1e-3);
  // The other faults are as they were.
  WrenchSensorSettings noisy = WrenchSensorSettings::realistic(), both = noisy;
  both.cross_talk = 0.02;
  WrenchSensor one(noisy, 1e-3, 5), other(both, 1e-3, 5);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(one.sample(Vector6::Zero()), other.sample(Vector6::Zero()));
}

TEST(WrenchSensor, NoiseIsWhiteNormalAndOfTheSdAskedFor) {
  WrenchSensorSettings settings;
  settings.noise_force = 0.1;
  settings.noise_torque = 0.005;
  const int samples = 200000;
  for (const double dt : {1e-3, 0.25e-3}) {
    WrenchSensor sensor(settings, dt, 42);
    const double rate = std::sqrt(1e-3 / dt);
    Matrix6 covariance = Matrix6::Zero(), lagged = Matrix6::Zero();
    Vector6 mean = Vector6::Zero(), fourth = Vector6::Zero(), last = Vector6::Zero();
    Vector6 sd;
    sd << 0.1, 0.1, 0.1, 0.005, 0.005, 0.005;
    for (int i = 0; i < samples; ++i) {
      const Vector6 z = (sensor.sample(some_wrench()) - some_wrench()).cwiseQuotient(rate * sd);
      mean += z / samples;
      covariance += z * z.transpose() / samples;
      lagged += z * last.transpose() / samples;
      fourth += z.cwiseAbs2().cwiseAbs2() / samples;
      last = z;
    }
    EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.01);  // SD of these: 0.0022
    EXPECT_LT((covariance - Matrix6::Identity()).cwiseAbs().maxCoeff(), 0.015);  // 0.0032
    EXPECT_LT(lagged.cwiseAbs().maxCoeff(), 0.01);
    EXPECT_LT((fourth - Vector6::Constant(3.0)).cwiseAbs().maxCoeff(),
              0.1);  // a normal distribution's; 0.022
  }
}

TEST(WrenchSensor, BiasHasItsLengthAndADirectionFromTheSeed) {
  WrenchSensorSettings settings;
  settings.bias_force = 1.5;
  settings.bias_torque = 0.05;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int seed = 0; seed < 1000; ++seed) {
    WrenchSensor sensor(settings, 1e-3, static_cast<std::uint64_t>(seed));
    const Vector6 bias = sensor.sample(some_wrench()) - some_wrench();
    EXPECT_NEAR(bias.head<3>().norm(), 1.5, 1e-12);
    EXPECT_NEAR(bias.tail<3>().norm(), 0.05, 1e-12);
    EXPECT_LT((sensor.sample(some_wrench()) - some_wrench() - bias).norm(), 1e-12);  // constant
    mean += bias.head<3>() / 1.5 / 1000.0;
  }
  EXPECT_LT(mean.norm(), 0.1);  // all directions alike: SD 0.018 on each axis
}

TEST(WrenchSensor, DriftsSoMuchInAMinute) {
  WrenchSensorSettings settings;
  settings.drift_force = 0.02;
  settings.drift_torque = 0.001;
  WrenchSensor sensor(settings, 1e-3, 7);
  const Vector6 first = sensor.sample(some_wrench());
  EXPECT_EQ(first, some_wrench());
  Vector6 half, last;
  for (int i = 1; i <= 60000; ++i) {
    last = sensor.sample(some_wrench());
    if (i == 30000) half = last;
  }
  EXPECT_NEAR((last - first).head<3>().norm(), 0.02, 1e-9);
  EXPECT_NEAR((last - first).tail<3>().norm(), 0.001, 1e-9);
  EXPECT_LT((0.5 * (last + first) - half).norm(), 1e-9);
}

TEST(WrenchSensor, ReadsInMultiplesOfItsQuantum) {
  WrenchSensorSettings settings;
  settings.quantum_force = 0.02;
  settings.quantum_torque = 0.001;
  WrenchSensor sensor(settings, 1e-3, 7);
  for (int i = 0; i < 1000; ++i) {
    const Vector6 F = std::sin(0.01 * i) * some_wrench(), y = sensor.sample(F);
    for (int k = 0; k < 6; ++k) {
      const double quantum = k < 3 ? 0.02 : 0.001;
      EXPECT_NEAR(y[k] / quantum, std::round(y[k] / quantum), 1e-9);
      EXPECT_LE(std::abs(y[k] - F[k]), quantum / 2 + 1e-12);
    }
  }
}

TEST(WrenchSensor, StopsAtTheEndOfItsRangeAndSaysSo) {
  WrenchSensorSettings settings;
  settings.range_force = 2.5;
  settings.range_torque = 0.25;
  WrenchSensor sensor(settings, 1e-3, 7);
  Vector6 expected;
  expected << 1.0, -2.0, 2.5, 0.1, -0.2, 0.25;
  EXPECT_EQ(sensor.sample(some_wrench()), expected);
  EXPECT_TRUE(sensor.saturated());
  EXPECT_EQ(sensor.sample(-some_wrench()), Vector6(-expected));
  EXPECT_TRUE(sensor.saturated());
  EXPECT_EQ(sensor.sample(0.5 * some_wrench()), Vector6(0.5 * some_wrench()));
  EXPECT_FALSE(sensor.saturated());
}

// Bias is added before saturation. At a range that is not a multiple of the quantum, the reading is
// still a multiple.
TEST(WrenchSensor, AddsThenSaturatesThenQuantises) {
  WrenchSensorSettings settings;
  settings.bias_force = 1.0;
  settings.range_force = 10.1;
  settings.quantum_force = 0.25;
  WrenchSensorSettings bias_only;
  bias_only.bias_force = 1.0;
  const Vector6 bias = WrenchSensor(bias_only, 1e-3, 3).sample(Vector6::Zero());
  WrenchSensor sensor(settings, 1e-3, 3);
  Vector6 F = Vector6::Zero();
  F[0] = 10.1 - 0.5 * std::abs(bias[0]);
  F[0] = std::copysign(F[0], bias[0]);
  ASSERT_GT(std::abs(bias[0]), 0.05);
  EXPECT_EQ(sensor.sample(F)[0], std::copysign(10.0, bias[0]));
  EXPECT_TRUE(sensor.saturated());
}

TEST(WrenchSensor, ReadsExactlySoManySamplesLate) {
  for (const int delay : {0, 1, 2, 30}) {
    WrenchSensorSettings settings;
    settings.delay = delay * 1e-3;
    settings.range_force = 100.5;
    WrenchSensor sensor(settings, 1e-3, 7);
    for (int i = 0; i < 150; ++i) {
      EXPECT_EQ(sensor.sample(i * Vector6::Unit(0))[0],
                std::min(100.5, std::max(0.0, 1.0 * i - delay)));
      EXPECT_EQ(sensor.saturated(),
                i - delay > 100);  // of the reading, not of what is still under way
    }
  }
}

TEST(WrenchSensor, TheSameSeedReadsTheSame) {
  const WrenchSensorSettings settings = WrenchSensorSettings::realistic();
  WrenchSensor a(settings, 1e-3, 5), b(settings, 1e-3, 5), c(settings, 1e-3, 6);
  int differ = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vector6 y = a.sample(some_wrench());
    EXPECT_EQ(y, b.sample(some_wrench()));
    differ += y != c.sample(some_wrench());
  }
  EXPECT_GT(differ, 990);
}

TEST(WrenchSensor, ARealisticOneErrsByItsBiasAndNoise) {
  WrenchSensor sensor(WrenchSensorSettings::realistic(), 1e-3, 5);
  Vector6 mean = Vector6::Zero(), square = Vector6::Zero();
  const int samples = 20000;
  for (int i = 0; i < samples; ++i) {
    const Vector6 error = sensor.sample(some_wrench()) - some_wrench();
    mean += error / samples;
    square += error.cwiseAbs2() / samples;
  }
  EXPECT_NEAR(mean.head<3>().norm(), 1.5, 0.01);
  EXPECT_NEAR(mean.tail<3>().norm(), 0.05, 0.001);
  const Vector6 sd = (square - mean.cwiseAbs2()).cwiseSqrt();
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(sd[k], k < 3 ? 0.1 : 0.005, k < 3 ? 0.003 : 0.00015);
}

TEST(WrenchSensor, RefusesASettingOutOfRangeByName) {
  const auto message = [](double WrenchSensorSettings::*field, double value) -> std::string {
    WrenchSensorSettings settings;
    settings.*field = value;
    try {
      WrenchSensor(settings, 1e-3, 1);
    } catch (const InputError& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_THAT(message(&WrenchSensorSettings::noise_torque, -0.1),
              testing::HasSubstr("noise_torque is -0.1 Nm, allowed is 0 to 10 Nm"));
  EXPECT_THAT(message(&WrenchSensorSettings::range_force, std::nan("")),
              testing::HasSubstr("range_force"));
  EXPECT_THAT(message(&WrenchSensorSettings::delay, 0.05),
              testing::HasSubstr("delay is 0.05 s, allowed is 0 to 0.03 s"));
  EXPECT_EQ(message(&WrenchSensorSettings::delay, 0.03), "accepted");
}

}  // namespace
}  // namespace impedraw

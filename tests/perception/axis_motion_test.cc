// The models of a coordinate's motion against closed forms, least squares and finite differences.
#include "impedraw/perception/axis_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

namespace impedraw {
namespace {

// A Kalman filter without process noise is recursive least squares.
TEST(AxisFilter, WithoutNoiseIsLeastSquares) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  constexpr int kSamples = 50;
  Eigen::MatrixXd A(kSamples, 3);
  Eigen::VectorXd b(kSamples);
  AxisFilter filter;
  double last = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const double t = 0.03 * i + 0.005 * std::sin(i);
    A.row(i) << 1.0, t, 0.5 * t * t;
    b[i] = 0.2 - 0.7 * t + 0.9 * t * t + 0.01 * normal(random);
    if (i == 0)
      filter = AxisFilter::started(b[0], 1e-4, 3);
    else
      filter.predict(t - last, {3, 0.0}), filter.measure(b[i], 1e-4);
    last = t;
  }
  const Eigen::Vector3d fit = A.colPivHouseholderQr().solve(b);
  // The filter starts with a wide prior of its own for velocity and acceleration.
  EXPECT_NEAR(filter.state.x, fit[0] + last * (fit[1] + 0.5 * last * fit[2]), 1e-3);
  EXPECT_NEAR(filter.state.v, fit[1] + last * fit[2], 5e-3);
  EXPECT_NEAR(filter.state.a, fit[2], 2e-2);
}

// P after one step from a certain state is the covariance of integrated white noise.
TEST(AxisFilter, GrowsUncertainAsIntegratedNoise) {
  for (int order = 1; order <= 3; ++order) {
    AxisFilter filter;
    filter.predict(0.5, {order, 2.0});
    const double t = 0.5,
                 expected[] = {2.0 * t, 2.0 * t * t * t / 3.0, 2.0 * std::pow(t, 5) / 20.0};
    EXPECT_NEAR(filter.P[0], expected[order - 1], 1e-12) << order;
    AxisFilter twice;
    twice.predict(0.2, {order, 2.0});
    twice.predict(0.3, {order, 2.0});
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(twice.P[k], filter.P[k], 1e-12) << order << " " << k;
  }
}

TEST(AxisPolynomial, DerivativesAreThoseOfItsValue) {
  AxisPolynomial p;
  p.origin = 1.0;
  p.span = 0.3;
  p.c = {0.1, -0.4, 0.3, 0.7, -0.2, 0.5};
  constexpr double h = 1e-5;
  for (double t = 1.05; t < 1.3; t += 0.04) {
    EXPECT_NEAR(p.at(t).v, (p.at(t + h).x - p.at(t - h).x) / (2 * h), 1e-7);
    EXPECT_NEAR(p.at(t).a, (p.at(t + h).v - p.at(t - h).v) / (2 * h), 1e-5);
  }
  EXPECT_NEAR(p.at(1.5).x, p.at(1.3).x + 0.2 * p.at(1.3).v, 1e-12) << "beyond: constant velocity";
  EXPECT_EQ(p.at(1.5).a, 0.0);
}

// Against the predictor that solves the dense system for each point of time anew.
TEST(BandLimited, IsTheLinearPredictorOfItsSpectrum) {
  constexpr double kCutoff = 1.1;
  std::vector<double> t, x, weights;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 60; ++i) {
    t.push_back(i / 30.0);
    x.push_back(0.03 * std::sin(5.0 * t[i]) + 0.1 * t[i] + 1e-4 * normal(random));
    weights.push_back(i % 3 ? 1.0 : 0.5);
  }
  BandLimited model;
  ASSERT_TRUE(model.set(kCutoff, t, weights));
  const AxisPolynomial got = model.predict(x);
  const auto k = [&](double a, double b) {
    const double u = 2.0 * std::numbers::pi * kCutoff * (a - b);
    return (u == 0.0 ? 1.0 : std::sin(u) / u) + 100.0 + 100.0 * (a - t.back()) * (b - t.back());
  };
  Eigen::MatrixXd K(60, 60);
  Eigen::VectorXd y(60);
  for (int i = 0; i < 60; ++i) {
    y[i] = x[i] - x.back();
    for (int j = 0; j < 60; ++j) K(i, j) = k(t[i], t[j]);
    K(i, i) += 1.0 / (BandLimited::kPower * weights[i]);
  }
  const Eigen::VectorXd a = K.fullPivLu().solve(y);
  for (double ahead = 0.0; ahead <= BandLimited::kSpan; ahead += 0.05) {
    double expected = x.back();
    for (int i = 0; i < 60; ++i) expected += k(t.back() + ahead, t[i]) * a[i];
    EXPECT_NEAR(got.at(t.back() + ahead).x, expected, 2e-6) << ahead;
    EXPECT_NEAR(expected, 0.03 * std::sin(5.0 * (t.back() + ahead)) + 0.1 * (t.back() + ahead),
                ahead < 0.15 ? 1e-3 : 5e-3);
  }
}

TEST(WaveFit, FindsTwoSwingsInNoise) {
  const unsigned seed = 11;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1e-4);
  const auto motion = [](double t) {
    return 0.2 + 0.05 * std::sin(2.0 * std::numbers::pi * 0.5 * t) +
           0.012 * std::cos(2.0 * std::numbers::pi * 1.2 * t + 0.4);
  };
  std::vector<AxisSample> samples;
  for (int i = 0; i < 180; ++i)
    samples.push_back({i / 30.0, motion(i / 30.0) + normal(random), 1e-8});
  const AxisWave wave = WaveFit::fit(samples, {}, true);
  ASSERT_TRUE(wave.fitted);
  EXPECT_NEAR(wave.rate[0] / (2.0 * std::numbers::pi), 0.5, 0.005);
  EXPECT_NEAR(wave.rate[1] / (2.0 * std::numbers::pi), 1.2, 0.01);
  for (double t = 6.0; t < 6.5; t += 0.05) EXPECT_NEAR(wave.at(t).x, motion(t), 2e-4);
  constexpr double h = 1e-5;
  EXPECT_NEAR(wave.at(6.1).v, (wave.at(6.1 + h).x - wave.at(6.1 - h).x) / (2 * h), 1e-7);
  EXPECT_NEAR(wave.at(6.1).a, (wave.at(6.1 + h).v - wave.at(6.1 - h).v) / (2 * h), 1e-6);
}

// 0.2 Hz apart, within 6 s. Found one after the other, each rate would wait for the other.
TEST(WaveFit, TellsTwoCloseSwingsApart) {
  const auto motion = [](double t) {
    return 0.05 * std::sin(2.0 * std::numbers::pi * 0.5 * t) -
           0.0054 * std::sin(2.0 * std::numbers::pi * 0.3 * t);
  };
  std::vector<AxisSample> samples;
  AxisWave wave;
  double worst = 0.0;
  for (int i = 0; i < 600; ++i) {
    const double t = i / 30.0, ahead = t + 0.077;
    samples.push_back({t, motion(t), 1e-12});
    if (samples.size() > 180) samples.erase(samples.begin());
    const bool search = i % 15 == 0;
    if (search || wave.fitted) wave = WaveFit::fit(samples, wave, search);
    if (t > 6.0) worst = std::max(worst, std::abs(wave.at(ahead).x - motion(ahead)));
  }
  EXPECT_LT(worst, 5e-5);
}

TEST(WaveFit, SeesNoSwingInNoiseAloneNorInTooShortATime) {
  std::mt19937 random(13);
  std::normal_distribution<double> normal(0.0, 1e-4);
  std::vector<AxisSample> samples;
  for (int i = 0; i < 180; ++i) samples.push_back({i / 30.0, 0.1 + normal(random), 1e-8});
  EXPECT_FALSE(WaveFit::fit(samples, {}, true).fitted);
  samples.resize(60);
  for (AxisSample& s : samples) s.x += 0.05 * std::sin(6.0 * s.time);
  EXPECT_FALSE(WaveFit::fit(samples, {}, true).fitted);
}

}  // namespace
}  // namespace impedraw

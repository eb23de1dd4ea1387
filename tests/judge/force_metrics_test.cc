// Metrics of the force benchmark against closed forms.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "impedraw/judge/force_metrics.h"

namespace impedraw {
namespace {

using std::numbers::pi;

constexpr double kStep = 1e-4;  // of the records [s]

template <typename Asked, typename Force>
std::vector<JudgedSample> recorded(double seconds, Asked asked, Force force, double speed = 0.0) {
  std::vector<JudgedSample> record;
  for (int i = 0; i * kStep < seconds; ++i)
    record.push_back({i * kStep, asked(i * kStep), force(i * kStep), speed});
  return record;
}

// Of ẍ/ω² + 2ζ ẋ/ω + x = step(t), from rest.
double second_order(double t, double omega, double zeta) {
  const double damped = omega * std::sqrt(1.0 - zeta * zeta);
  return 1.0 - std::exp(-zeta * omega * t) *
                   (std::cos(damped * t) + zeta * omega / damped * std::sin(damped * t));
}

TEST(ForceMetrics, StepOfASecondOrderSystem) {
  for (const double zeta : {0.2, 0.4, 0.7})
    for (const double size : {4.0, -3.0}) {
      const double omega = 50.0;
      ForceQuestion question;
      question.to = 2.0;
      question.changes = {{0.0, 2.0, 5.0, 5.0 + size}};
      question.steady = {{1.8, 2.0}};
      const ForceMetrics found =
          judge_force(recorded(
                          2.0, [&](double) { return 5.0 + size; },
                          [&](double t) { return 5.0 + size * second_order(t, omega, zeta); }),
                      question);
      EXPECT_NEAR(*found.value[kOvershoot], std::exp(-pi * zeta / std::sqrt(1.0 - zeta * zeta)),
                  1e-4);
      // The last time outside of ± 5 %, by bisection from the envelope inwards.
      double last = 0.0;
      for (double t = 0.0; t < 2.0; t += 1e-5)
        if (std::abs(second_order(t, omega, zeta) - 1.0) > 0.05) last = t;
      EXPECT_NEAR(*found.value[kSettlingTime], last, 2.0 * kStep);
      EXPECT_NEAR(*found.value[kSteadyError], 0.0, 1e-6);
    }
}

TEST(ForceMetrics, OneThatNeverSettlesHasNoSettlingTime) {
  ForceQuestion question;
  question.to = 2.0;
  question.changes = {{0.0, 1.0, 0.0, 5.0}, {1.0, 2.0, 5.0, 6.0}};
  const auto asked = [](double t) { return t < 1.0 ? 5.0 : 6.0; };
  // 0.3 N is within 5 % of neither, but within the first's 0.25 N with 0.2 N.
  EXPECT_FALSE(judge_force(recorded(2.0, asked, [&](double t) { return asked(t) + 0.2; }), question)
                   .value[kSettlingTime]);
  EXPECT_EQ(judge_force(recorded(2.0, asked, [&](double t) { return asked(t) + 0.09; }), question)
                .value[kSettlingTime],
            0.0);
}

TEST(ForceMetrics, SineAboutTheCommand) {
  const double amplitude = 0.8, mean = 0.3;
  ForceQuestion question;
  question.to = 2.0;
  question.steady = {{0.0, 2.0}};
  question.moves = true;
  const ForceMetrics found = judge_force(
      recorded(
          2.0, [](double) { return 5.0; },
          [&](double t) { return 5.0 - mean + amplitude * std::sin(2.0 * pi * 5.0 * t); }, 0.05),
      question);
  EXPECT_NEAR(*found.value[kSd], amplitude / std::sqrt(2.0), 1e-4);
  EXPECT_NEAR(*found.value[kSteadyError], mean, 1e-4);
  EXPECT_NEAR(*found.value[kRms], std::hypot(mean, amplitude / std::sqrt(2.0)), 1e-4);
  // ∫ max(0, mean − a sin) over a period: with s = asin(mean/a), (mean (π + 2 s) + 2 a cos s)/2π.
  const double s = std::asin(mean / amplitude);
  EXPECT_NEAR(*found.value[kWorkLost],
              0.05 * 2.0 * (mean * (pi + 2.0 * s) + 2.0 * amplitude * std::cos(s)) / (2.0 * pi),
              1e-4);
}

// A lag of first order, integrated exactly from sample to sample.
TEST(ForceMetrics, BandwidthOfALag) {
  for (const double corner : {3.0, 10.0, 25.0}) {
    ForceQuestion question;
    question.sweep.emplace();
    question.to = question.sweep->duration;
    double force = question.sweep->mean;
    const double decay = std::exp(-2.0 * pi * corner * kStep);
    const ForceMetrics found = judge_force(
        recorded(
            question.to, [&](double t) { return question.sweep->at(t); },
            [&](double t) {
              return force += (1.0 - decay) * (question.sweep->at(t + 0.5 * kStep) - force);
            }),
        question);
    EXPECT_NEAR(*found.value[kBandwidth], corner, 0.03 * corner);
  }
}

TEST(ForceMetrics, SweepsRateIsItsDerivative) {
  const ForceSweep sweep;
  for (double t = 0.1; t < 9.9; t += 0.37) {
    EXPECT_NEAR(sweep.rate(t), (sweep.at(t + 1e-6) - sweep.at(t - 1e-6)) / 2e-6, 1e-3);
    EXPECT_NEAR(sweep.frequency(t), (sweep.phase(t + 1e-6) - sweep.phase(t - 1e-6)) / (4e-6 * pi),
                1e-4);
  }
  EXPECT_NEAR(sweep.at(sweep.start), sweep.mean, 1e-12) << "it begins without a jump";
}

TEST(ForceMetrics, NothingJudgedGivesNothing) {
  ForceQuestion question;
  question.from = 5.0;
  question.to = 6.0;
  question.changes = {{5.0, 6.0, 0.0, 5.0}};
  const auto five = [](double) { return 5.0; };
  for (const auto& value : judge_force(recorded(1.0, five, five), question).value)
    EXPECT_FALSE(value);
}

}  // namespace
}  // namespace impedraw

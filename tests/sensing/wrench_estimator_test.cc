// The tool's weight and inertia go out of the reading, late or not, and the rest comes to the tip;
// faults spoil nothing.
#include "impedraw/sensing/wrench_estimator.h"

#include <cstdio>
#include <cstdlib>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "allocations.h"
#include "impedraw/common/errors.h"
#include "still_pen.h"
#include "waved_tool.h"

namespace impedraw {
namespace {

using namespace waved_tool;
using namespace still_pen;

struct Worst {
  double force = 0.0, torque = 0.0;
};

// Rest and tare, then 5 s of waving; the worst error of F_ext from `start` on, against the wrench
// that acts on the tip.
Worst wave(const WrenchEstimatorSettings& settings, int late_steps = 0,
           const Vector6& F_tip_W = Vector6::Zero(), double start = 0.0) {
  const std::vector<PointMass> points = point_masses();
  const Pose X_SE = tip_in_sensor();
  WrenchEstimator estimator(settings);
  Worst worst;
  for (int i = -500; i < 5000; ++i) {
    const double t = i * kDt, t_read = t - late_steps * kDt;
    const Vector6 F_W = t_read > 0.5 * kDt ? F_tip_W : Vector6::Zero();
    const Vector6 F = estimator.update(reading(t_read, points, F_W) + kBias, sensor_pose(t) * X_SE,
                                       velocity(t, X_SE));
    EXPECT_FALSE(estimator.fault());
    if (t < start) continue;
    EXPECT_TRUE(estimator.tared());
    worst.force = std::max(worst.force, (F - F_W).head<3>().norm());
    worst.torque = std::max(worst.torque, (F - F_W).tail<3>().norm());
  }
  return worst;
}

void print(const char* what, const Worst& worst) {
  std::printf("  %-28s %.6f N  %.6f Nm\n", what, worst.force, worst.torque);
}

constexpr double kForceAccuracy = 1e-4,
                 kTorqueAccuracy = 1e-5;  // second order in the step: first order would be 1e-2 N

TEST(WrenchEstimator, AToolWavedInTheAirReadsNothing) {
  const Worst worst = wave(settings_for(tool_of(point_masses())));
  print("all removed", worst);
  EXPECT_LT(worst.force, kForceAccuracy);
  EXPECT_LT(worst.torque, kTorqueAccuracy);
}

TEST(WrenchEstimator, AWrenchOnTheWavedTipComesOut) {
  const Vector6 F_W = (Vector6() << 2.0, -1.0, 5.0, 0.1, 0.2, -0.05).finished();
  const Worst worst = wave(settings_for(tool_of(point_masses())), 0, F_W);
  print("with a wrench on the tip", worst);
  EXPECT_LT(worst.force, kForceAccuracy);
  EXPECT_LT(worst.torque, kTorqueAccuracy);
}

TEST(WrenchEstimator, ADelayThatIsToldDoesNoHarm) {
  WrenchEstimatorSettings settings = settings_for(tool_of(point_masses()));
  const Worst untold = wave(settings, 2, Vector6::Zero(), 0.1);  // past the jolt of the start
  settings.sensor_delay = 2e-3;
  const Worst told = wave(settings, 2);
  print("2 ms late, told", told);
  print("2 ms late, not told", untold);
  EXPECT_LT(told.force, kForceAccuracy);
  EXPECT_LT(told.torque, kTorqueAccuracy);
  EXPECT_GT(untold.force, 100.0 * kForceAccuracy);
  EXPECT_GT(untold.torque, 100.0 * kTorqueAccuracy);
  settings.sensor_delay = WrenchEstimator::kMaxDelaySteps * kDt;  // the whole ring
  EXPECT_LT(wave(settings, WrenchEstimator::kMaxDelaySteps).force, kForceAccuracy);
  EXPECT_DOUBLE_EQ(WrenchEstimator(settings).group_delay(), settings.sensor_delay);
}

TEST(WrenchEstimator, ComesToTheTipAsByHand) {
  WrenchEstimatorSettings settings = still_settings();
  settings.X_ES.p << 0.0, 0.0, -0.2;              // 0.2 m up the pen
  settings.X_ES.R << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // a quarter turn: x_S = y_E
  Still still(settings);
  ASSERT_GT(still.steps_to_tare(Vector6::Zero()), 0);
  // 5 N up, 2 N along x_W = x_E and 0.1 Nm about z_W at the tip. In the axes of E: f = (2, 0, −5),
  // about S's origin m = (0, 0, 0.2) × f + (0, 0, −0.1) = (0, 0.4, −0.1). In S: x_S = y_E, y_S =
  // −x_E.
  const Vector6 F = still.read((Vector6() << 0.0, -2.0, -5.0, 0.4, 0.0, -0.1).finished());
  EXPECT_LT((F - (Vector6() << 2.0, 0.0, 5.0, 0.0, 0.0, 0.1).finished()).norm(), 1e-12)
      << F.transpose();
}

TEST(WrenchEstimator, ALongerPenIsAsIfItHadBeenSoLongFromTheStart) {
  WrenchEstimatorSettings settings = still_settings(), longer = settings;
  settings.X_ES.p << 0.01, 0.02, -0.2;
  longer.X_ES.p << 0.01, 0.02, -0.23;
  Still changed(settings), known(longer);
  changed.estimator.lengthen_pen(0.03);
  ASSERT_GT(changed.steps_to_tare(kBias), 0);
  ASSERT_GT(known.steps_to_tare(kBias), 0);
  const Vector6 reading = kBias + 2.0 * Vector6::Ones();
  EXPECT_EQ(changed.read(reading), known.read(reading));
}

TEST(WrenchEstimator, AFaultKeepsTheLastWrench) {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               inf = std::numeric_limits<double>::infinity();
  WrenchEstimatorSettings settings = still_settings();
  settings.range_force = 100.0;
  settings.range_torque = 10.0;
  settings.sensor_delay = 2e-3;
  Still still(settings);
  ASSERT_GT(still.steps_to_tare(Vector6::Zero()), 0);
  const Vector6 good = (Vector6() << 1, 2, 3, 0.1, 0.2, 0.3).finished();
  const Vector6 F = still.read(good);
  EXPECT_FALSE(still.estimator.fault());
  for (const double bad : {nan, inf, -inf, 100.0, -100.0, 500.0}) {
    for (const int axis : {0, 2, 3, 5}) {
      Vector6 reading_S = 1.1 * good;
      reading_S[axis] = bad;
      EXPECT_EQ(still.read(reading_S), F);
      EXPECT_TRUE(still.estimator.fault()) << bad << " on axis " << axis;
    }
  }
  EXPECT_NEAR(still.read((Vector6() << 99.9, 0, 0, 0, 0, -9.9).finished())[0], 99.9, 1e-9);
  EXPECT_FALSE(still.estimator.fault());
  still.read(good);

  // A motion that is not known spoils the readings of its time: 2 steps late, and one for the
  // difference.
  still.read(1.1 * good, Vector6::Constant(nan));
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(still.estimator.fault());
    EXPECT_EQ(still.read(1.1 * good), F);
  }
  still.read(1.1 * good);
  EXPECT_FALSE(still.estimator.fault());
  EXPECT_LT((still.estimator.F_ext() - 1.1 * F).norm(), 1e-12);
}

TEST(WrenchEstimator, NoNanComesOutAndNothingIsAllocated) {
  const int seed = 9;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  std::normal_distribution<double> normal(0.0, 1.0);
  WrenchEstimatorSettings settings = settings_for(tool_of(point_masses()));
  settings.tare_time = 0.02;
  settings.filter_bandwidth = 300.0;
  settings.sensor_delay = 2e-3;
  WrenchEstimator estimator(settings);
  const double bad[] = {std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::infinity()};
  int finite = 0, faults = 0, sound = 0;
  const int made = allocations_in([&] {
    for (int i = 0; i < 20000; ++i) {
      const bool still = i % 2000 < 200;
      Vector6 reading_S = Vector6::NullaryExpr([&] { return 10.0 * normal(rng); });
      Vector6 V = (still ? 0.0 : 1.0) * Vector6::NullaryExpr([&] { return normal(rng); });
      Pose X{{normal(rng), 0.0, 0.0}, Eigen::Matrix3d::Identity()};
      if (u(rng) < 0.01) reading_S[i % 6] = bad[i % 2];
      if (u(rng) < 0.01) V[i % 6] = bad[i % 2];
      if (u(rng) < 0.01) X.R(i % 3, 0) = bad[i % 2];
      if (i % 2000 == 0) estimator.start_tare();
      finite += estimator.update(reading_S, X, V).allFinite();
      faults += estimator.fault();
      sound += !estimator.fault() && estimator.F_ext().norm() > 0.1;
    }
  });
  EXPECT_EQ(made, 0);
#ifndef IMPEDRAW_OWN_ALLOCATOR
  EXPECT_GT(allocations_in([] {
              std::vector<double> v(10);
              asm volatile("" : : "r"(v.data()) : "memory");
            }),
            0)
      << "the hook catches none";
#endif
  EXPECT_EQ(finite, 20000);
  EXPECT_TRUE(estimator.tared());
  EXPECT_GT(faults, 500);
  EXPECT_GT(sound, 10000);
}

TEST(WrenchEstimator, RefusesWhatCannotBe) {
  const auto refusal = [](auto change) -> std::string {
    WrenchEstimatorSettings settings;
    change(settings);
    try {
      WrenchEstimator estimator(settings);
    } catch (const InputError& error) {
      return error.what();
    }
    return "taken";
  };
  using S = WrenchEstimatorSettings;
  using testing::HasSubstr;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal([](S&) {}), "taken");
  EXPECT_EQ(refusal([](S& s) { s.sensor_delay = 0.032; }), "taken");
  EXPECT_THAT(refusal([](S& s) { s.sensor_delay = 0.033; }),
              HasSubstr("sensor_delay = 0.033 s, must be in 0 … 0.032 s"));
  EXPECT_THAT(refusal([](S& s) { s.sensor_delay = -1e-3; }), HasSubstr("sensor_delay"));
  EXPECT_THAT(refusal([&](S& s) { s.sensor_delay = nan; }), HasSubstr("sensor_delay"));
  EXPECT_THAT(refusal([](S& s) { s.dt = 0.0; }), HasSubstr("dt = 0"));
  EXPECT_THAT(refusal([](S& s) { s.filter_bandwidth = 2000.0; }), HasSubstr("filter_bandwidth"));
  EXPECT_THAT(refusal([](S& s) { s.tare_time = 0.0; }), HasSubstr("tare_time"));
  EXPECT_THAT(refusal([](S& s) { s.tare_speed = 0.0; }), HasSubstr("tare_speed"));
  EXPECT_THAT(refusal([](S& s) { s.tare_turn_rate = -1.0; }), HasSubstr("tare_turn_rate"));
  EXPECT_THAT(refusal([](S& s) { s.range_force = 0.0; }), HasSubstr("range_force"));
  EXPECT_THAT(refusal([&](S& s) { s.range_torque = nan; }), HasSubstr("range_torque"));
  EXPECT_THAT(refusal([](S& s) { s.X_ES.R(0, 0) = -1.0; }), HasSubstr("X_ES"));
  EXPECT_THAT(refusal([&](S& s) { s.gravity_W[1] = nan; }), HasSubstr("gravity_W"));
  EXPECT_THAT(refusal([](S& s) { s.tool.mass = -0.1; }), HasSubstr("tool.mass is -0.1 kg"));
  EXPECT_THAT(refusal([](S& s) { s.tool.I_SC(0, 1) = 1e-3; }), HasSubstr("symmetric"));
  EXPECT_THAT(refusal([](S& s) { s.tool.I_SC.diagonal() << 1e-3, 1e-3, 3e-3; }),
              HasSubstr("principal moments"));
}

}  // namespace
}  // namespace impedraw

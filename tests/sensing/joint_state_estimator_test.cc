// The estimate against motions known in closed form: exact where the model is, without lag and
// whatever the delays; and what noise and unmodelled torque do to it.
#include "impedraw/sensing/joint_state_estimator.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "allocations.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

constexpr double kDt = 1e-3;

// Two joints, M = diag(2, 0.01), gravity 3 and 0.2 Nm, at rest until t = 0, then
// q_j = A_j (1 − cos ω_j t)/2.
struct Motion {
  Eigen::Vector2d A{0.3, 0.8}, w{4.0, 11.0}, M{2.0, 0.01}, g{3.0, 0.2};

  JointVector q(double t) const {
    if (t <= 0.0) return JointVector::Zero(2);
    return (0.5 * A.array() * (1.0 - (w * t).array().cos())).matrix();
  }
  JointVector v(double t) const {
    if (t <= 0.0) return JointVector::Zero(2);
    return (0.5 * A.array() * w.array() * (w * t).array().sin()).matrix();
  }
  JointVector tau(double t) const {
    JointVector a = JointVector::Zero(2);
    if (t > 0.0) a = (0.5 * A.array() * w.array().square() * (w * t).array().cos()).matrix();
    return M.cwiseProduct(a) + g;
  }
};

struct Errors {
  double q = 0.0, v = 0.0;              // largest
  double v_sd = 0.0;                    // of the second joint
  double noise = 0.0, bandwidth = 0.0;  // at the end: of the second joint's readings, as measured
};

// Lets the estimator follow the motion for 3 s; errors from `from` on. `unknown`: a torque on the
// second joint that the model lacks, from t = 0 on. `noise`, `quantum`: of the readings [rad].
Errors follow(const JointStateEstimatorSettings& settings, double from, double unknown = 0.0,
              double noise = 0.0, double quantum = 0.0) {
  const Motion motion;
  JointStateEstimator estimator(settings, 2);
  std::mt19937 rng(1);
  std::normal_distribution<double> normal;
  ArmTerms terms(2);
  terms.M.diagonal() = motion.M;
  terms.g = motion.g;
  Errors errors;
  double squares = 0.0;
  int count = 0;
  for (int i = -50; i < 3000; ++i) {
    const double t = i * kDt;
    JointVector reading = motion.q(t - settings.sensor_delay);
    for (double& x : reading) x += noise * normal(rng);
    if (quantum > 0.0)
      for (double& x : reading) x = quantum * std::round(x / quantum);
    estimator.update(reading);
    if (t >= from) {
      errors.q = std::max(errors.q, (estimator.q() - motion.q(t)).cwiseAbs().maxCoeff());
      const JointVector dv = estimator.v() - motion.v(t);
      errors.v = std::max(errors.v, dv.cwiseAbs().maxCoeff());
      squares += dv[1] * dv[1];
      ++count;
    }
    // The torque that makes the motion of the step in which this command will act, at its middle.
    JointVector tau = motion.tau(t + settings.torque_delay + 0.5 * kDt);
    if (t + settings.torque_delay >= 0.0) tau[1] -= unknown;
    estimator.commanded(terms, Vector6::Zero(), tau);
  }
  errors.v_sd = std::sqrt(squares / count);
  errors.noise = estimator.noise()[1];
  errors.bandwidth = estimator.bandwidth();
  return errors;
}

TEST(JointStateEstimator, HasNoLagWhereTheModelHolds) {
  for (const double sensor_delay : {0.0, 1e-3, 5e-3})
    for (const double torque_delay : {0.0, 2e-3}) {
      SCOPED_TRACE(testing::Message() << sensor_delay << " s and " << torque_delay << " s");
      const Errors e = follow({kDt, 300.0, sensor_delay, torque_delay}, 0.0);
      EXPECT_LT(e.q, 2e-5);
      EXPECT_LT(e.v, 5e-3) << "of 4.4 rad/s; a delay of a step would be 0.05 rad/s";
    }
  // The defect: a delay that the estimator is not told.
  const Motion motion;
  JointStateEstimator untold({kDt, 300.0, 0.0, 0.0}, 2);
  double worst = 0.0;
  for (int i = 0; i < 1000; ++i) {
    untold.update(motion.q((i - 5) * kDt));
    worst = std::max(worst, (untold.v() - motion.v(i * kDt)).cwiseAbs().maxCoeff());
  }
  EXPECT_GT(worst, 0.1);
}

TEST(JointStateEstimator, LearnsAConstantTorqueThatTheModelLacks) {
  const double unknown = 0.05;  // 5 rad/s²
  const Errors at_once = follow({kDt, 300.0, 1e-3, 0.0}, 0.0, unknown),
               later = follow({kDt, 300.0, 1e-3, 0.0}, 0.05, unknown);
  EXPECT_GT(at_once.v, 0.01);
  EXPECT_LT(later.v, 5e-3);
}

TEST(JointStateEstimator, FiltersNoise) {
  const double sigma = 1e-5;
  for (const double bandwidth : {100.0, 300.0}) {
    const Errors e = follow({kDt, bandwidth, 0.0, 0.0}, 0.2, 0.0, sigma);
    const double quoted = 2.0 * sigma * std::sqrt(std::pow(bandwidth, 3) * kDt);
    EXPECT_LT(e.v_sd, 1.3 * quoted + 2e-3) << bandwidth;
    EXPECT_LT(e.v_sd, 0.3 * std::sqrt(2.0) * sigma / kDt) << "a difference has more";
  }
}

// The noise that was put in is found beside a motion of 4.4 rad/s and 48 rad/s², and beside a
// torque that the model lacks.
TEST(JointStateEstimator, MeasuresTheNoiseOfTheReadings) {
  for (const double sigma : {1e-6, 3e-6, 1e-5, 1e-4})
    EXPECT_NEAR(follow({kDt, 300.0, 1e-3, 0.0}, 0.2, 0.05, sigma).noise, sigma, 0.15 * sigma);
  EXPECT_LT(follow({kDt, 300.0, 0.0, 0.0}, 0.2).noise, 1e-6)
      << "48 rad/s² at once, two seconds ago";
  for (const double quantum : {1e-5, 1e-4}) {
    const double rounding = quantum / std::sqrt(12.0);
    EXPECT_NEAR(follow({kDt, 300.0, 0.0, 0.0}, 0.2, 0.0, 0.0, quantum).noise, rounding,
                0.3 * rounding);
  }
}

// The defect: with 3e-5 rad of noise the velocity had 15e-3 rad/s of it at 400 rad/s.
TEST(JointStateEstimator, NoiseLowersTheBandwidth) {
  const JointStateEstimatorSettings settings{kDt, 400.0, 0.0, 0.0, 100.0};
  EXPECT_EQ(follow(settings, 0.5, 0.0, 0.0, 1e-5).bandwidth, 400.0) << "that much is borne";
  for (const double sigma : {1e-5, 2e-5, 3e-5}) {
    const Errors e = follow(settings, 0.5, 0.0, sigma);
    const double most = JointStateEstimator::kVelocityNoise;
    EXPECT_NEAR(2.0 * sigma * std::sqrt(std::pow(e.bandwidth, 3) * kDt), most, 0.25 * most);
    EXPECT_LT(e.v_sd, 1.3 * most) << sigma;
  }
  EXPECT_EQ(follow(settings, 0.5, 0.0, 1e-3).bandwidth, 100.0) << "no further";
  JointStateEstimatorSettings fixed = settings;
  fixed.least_bandwidth = 400.0;
  EXPECT_EQ(follow(fixed, 0.5, 0.0, 3e-5).bandwidth, 400.0);
  EXPECT_GT(follow(fixed, 0.5, 0.0, 3e-5).v_sd, 8e-3);
}

TEST(JointStateEstimator, CoastsThroughMissingReadings) {
  const Motion motion;
  JointStateEstimator estimator({kDt, 300.0, 0.0, 0.0}, 2);
  ArmTerms terms(2);
  terms.M.diagonal() = motion.M;
  terms.g = motion.g;
  const JointVector lost = JointVector::Constant(2, std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < 1000; ++i) {
    const double t = i * kDt;
    const bool missing = i >= 500 && i < 520;
    if (missing && i % 2)
      estimator.update(lost);
    else if (missing)
      estimator.coast();
    else
      estimator.update(motion.q(t));
    ASSERT_LT((estimator.v() - motion.v(t)).cwiseAbs().maxCoeff(), 0.02) << i;
    estimator.commanded(terms, Vector6::Zero(), motion.tau(t + 0.5 * kDt));
  }
}

// Cycles in which the controller did not run: the drives held the torque.
TEST(JointStateEstimator, AdvancesBySeveralSteps) {
  JointStateEstimator estimator({kDt, 300.0, 0.0, 0.0}, 1);
  ArmTerms terms(1);
  terms.M(0, 0) = 2.0;
  const JointVector tau = JointVector::Constant(1, 4.0);  // 2 rad/s²
  int i = 0;                                              // steps since the first reading
  for (const int steps : {0, 1, 1, 30, 1, 5, 1}) {
    i += steps;
    estimator.update(JointVector::Constant(1, std::pow(i * kDt, 2)), steps);
    EXPECT_NEAR(estimator.v()[0], 2.0 * i * kDt, 1e-9);
    estimator.commanded(terms, Vector6::Zero(), tau);
  }
}

TEST(JointStateEstimator, UsesTheWrench) {
  JointStateEstimator estimator({kDt, 30.0, 0.0, 0.0}, 1);
  ArmTerms terms(1);
  terms.M(0, 0) = 2.0;
  terms.J(2, 0) = 0.5;
  Vector6 F = Vector6::Zero();
  F[2] = 8.0;  // 4 Nm: 2 rad/s²
  for (int i = 0; i < 100; ++i) {
    estimator.update(JointVector::Constant(1, std::pow(i * kDt, 2)));
    ASSERT_NEAR(estimator.v()[0], 2.0 * i * kDt, 1e-9);
    estimator.commanded(terms, F, JointVector::Zero(1));
  }
}

TEST(JointStateEstimator, AllocatesNothing) {
  JointStateEstimator estimator({kDt, 300.0, 3e-3, 2e-3}, 7);
  ArmTerms terms(7);
  terms.M.setIdentity();
  const JointVector q = JointVector::Zero(7);
  const int made = allocations_in([&] {
    for (int i = 0; i < 100; ++i) {
      estimator.update(q, 1 + i % 3);
      estimator.commanded(terms, Vector6::Ones(), q);
      estimator.coast();
      if (i == 50) estimator.reset();
    }
  });
  EXPECT_EQ(made, 0);
}

TEST(JointStateEstimator, RefusesWhatCannotBe) {
  const auto refusal = [](const JointStateEstimatorSettings& s) -> std::string {
    try {
      JointStateEstimator(s, 7);
    } catch (const InputError& e) {
      return e.what();
    }
    return {};
  };
  EXPECT_EQ(refusal({kDt, 300.0, 0.0, 0.0}), "");
  EXPECT_NE(refusal({0.0, 300.0, 0.0, 0.0}).find("dt"), std::string::npos);
  EXPECT_NE(refusal({kDt, 1000.0, 0.0, 0.0}).find("bandwidth"), std::string::npos);
  EXPECT_NE(refusal({kDt, 300.0, 0.05, 0.0}).find("sensor_delay"), std::string::npos);
  EXPECT_NE(refusal({kDt, 300.0, 0.0, -1e-3}).find("torque_delay"), std::string::npos);
  EXPECT_NE(refusal({kDt, 300.0, 0.0, 0.0, 0.0}).find("least_bandwidth"), std::string::npos);
}

// The error after a jump is that of a linear filter with the characteristic polynomial (z − θ)³.
TEST(JointStateEstimator, HasThreePolesAtItsBandwidth) {
  JointStateEstimatorSettings s;
  s.least_bandwidth = s.bandwidth;
  JointStateEstimator estimator(s, 1);
  estimator.update(JointVector::Zero(1));
  const double theta = std::exp(-s.bandwidth * s.dt);
  double e[4] = {};
  for (int k = 0; k < 20; ++k) {
    estimator.update(JointVector::Constant(1, 1e-3));
    for (int i = 3; i > 0; --i) e[i] = e[i - 1];
    e[0] = estimator.q()[0] - 1e-3;
    if (k < 3) continue;
    EXPECT_NEAR(e[0], 3 * theta * e[1] - 3 * theta * theta * e[2] + std::pow(theta, 3) * e[3],
                1e-15);
  }
  EXPECT_LT(std::abs(e[0]), 1e-4);
}

}  // namespace
}  // namespace impedraw

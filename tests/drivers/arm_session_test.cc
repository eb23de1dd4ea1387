// The session's promises, whatever arrives: torque bounded in size and rate, a named state, nothing
// sent too early, zero last.
#include "impedraw/drivers/arm_session.h"

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "seeds.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

constexpr int kJoints = 3;

SessionSettings settings() {
  SessionSettings s;
  s.torque_limit = JointVector::Constant(kJoints, 40.0);
  s.speed_limit = JointVector::Constant(kJoints, 2.0);
  s.external_limit = JointVector::Constant(kJoints, 20.0);
  s.rated_speed = JointVector::Constant(kJoints, 2.0);
  s.damping = [](const JointVector& q, const JointVector& v) {
    EXPECT_TRUE(q.allFinite());
    return JointVector(-3.0 * v);
  };
  return s;
}

JointVector all(double x) { return JointVector::Constant(kJoints, x); }

ArmStatus at(std::int64_t utime, double v = 0.0) {
  ArmStatus status(kJoints);
  status.utime = utime;
  status.v = all(v);
  return status;
}

// A session that has just left the quiet time; the last status is at 1.25 s.
ArmSession begun() {
  ArmSession session(settings());
  for (int ms = 0; ms <= 250; ++ms) session.receive(at(1'000'000 + 1000 * ms), 1e-3 * ms + 1e-9);
  EXPECT_EQ(session.state(), SessionState::start);
  return session;
}

TEST(ArmSession, NothingMayBeSentWithinTheQuietTimeOfEitherClock) {
  ArmSession slow(settings());  // the arm's clock runs at half the wall's speed
  ArmSession fast(settings());  // at twice
  for (int ms = 0; ms < 250; ++ms) {
    EXPECT_FALSE(slow.receive(at(1 + 1000 * ms), 2e-3 * ms)) << ms;
    EXPECT_FALSE(fast.receive(at(1 + 2000 * ms), 1e-3 * ms)) << ms;
  }
  EXPECT_TRUE(slow.receive(at(250'001), 0.5));
  EXPECT_TRUE(fast.receive(at(500'001), 0.25));
}

TEST(ArmSession, TheTorqueIsRampedUpFromTheFirstCommand) {
  ArmSession session = begun();
  for (int ms = 1; ms <= 300; ++ms) {
    ASSERT_TRUE(session.receive(at(1'250'000 + 1000 * ms), 0.25 + 1e-3 * ms));
    const JointVector tau = session.answer(all(10.0));
    const double share = std::min(1.0, (ms - 1) / 200.0);
    EXPECT_NEAR(tau[0], 10.0 * share, 1e-9) << ms;
  }
  EXPECT_EQ(session.state(), SessionState::run);
}

TEST(ArmSession, AStopDampsAndEndsWithZero) {
  ArmSession session = begun();
  std::int64_t utime = 1'250'000;
  double now = 0.25, v = 1.0;
  const auto cycle = [&] {
    ArmStatus status = at(utime += 1000, v);
    status.q = all(1e-6 * v * static_cast<double>(utime - 1'250'000));
    session.receive(status, now += 1e-3);
    return JointVector(session.answer(all(9.0)));
  };
  for (int i = 0; i < 300; ++i) cycle();
  session.stop();
  EXPECT_EQ(session.state(), SessionState::stop);
  JointVector tau = all(9.0);
  for (int i = 0; i < 20; ++i) tau = cycle();
  EXPECT_NEAR(tau[1], -3.0 * v, 1e-12);
  int cycles = 0;
  for (; session.may_send() && cycles < 1000; ++cycles) tau = cycle();
  EXPECT_EQ(session.state(), SessionState::ended);
  EXPECT_LT(cycles, 400);
  EXPECT_TRUE(tau.isZero(0.0));
  EXPECT_TRUE(session.cause().empty());
}

// Statuses go on, but what they tell of an arm that began at rest stands still from 0.1 s on:
// positions, and speeds or none.
TEST(ArmSession, PositionsThatStandStillAreAFaultWithin10Milliseconds) {
  for (const double told : {0.0, 0.05}) {
    SCOPED_TRACE(told);
    SessionSettings s = settings();
    s.inertia = JointMatrix::Identity(kJoints, kJoints);
    ArmSession session(s);
    int fault = 0;
    for (int ms = 0; ms <= 200 && fault == 0; ++ms) {
      const double begun = std::min(1.0, ms / 50.0), on = std::min(std::max(ms, 50), 100) - 50;
      ArmStatus status = at(1'000'000 + 1000 * ms, ms <= 100 ? 0.05 * begun * begun : told);
      status.q = all(5e-5 * (50.0 / 3.0 * begun * begun * begun + on));
      session.receive(status, 1e-3 * ms + 1e-9);
      if (!session.cause().empty()) fault = ms;
    }
    EXPECT_NEAR(fault, 108, 1);
    EXPECT_THAT(session.cause(), HasSubstr("0.050 rad/s"));
  }
}

TEST(ArmSession, SilenceIsAFaultAndLowersTheTorqueByItself) {
  ArmSession session = begun();
  for (int ms = 1; ms <= 300; ++ms) {
    session.receive(at(1'250'000 + 1000 * ms), 0.25 + 1e-3 * ms);
    session.answer(all(30.0));
  }
  session.tick(0.55 + 0.049);
  EXPECT_EQ(session.state(), SessionState::run);
  session.tick(0.55 + 0.051);
  EXPECT_EQ(session.state(), SessionState::fault);
  EXPECT_EQ(session.cause(), "no status of the arm for 0.051 s");
  int cycles = 0;
  for (; session.may_send() && cycles < 100; ++cycles) session.answer(all(30.0), true);
  EXPECT_NEAR(cycles, 30.0 / 0.9, 2.0);  // at 900 Nm/s, a millisecond each
  EXPECT_TRUE(session.sent().isZero(0.0));
}

TEST(ArmSession, FaultsAreNamed) {
  const auto cause = [](const auto& happen) {
    ArmSession session = begun();
    session.receive(at(1'251'000), 0.251);
    session.answer(all(0.0));
    happen(session);
    EXPECT_TRUE(session.state() == SessionState::fault || session.state() == SessionState::ended);
    return session.cause();
  };
  EXPECT_EQ(cause([](ArmSession& s) { s.receive(at(1'252'000, 2.5), 0.252); }),
            "joint 1 turns at 2.50 rad/s, more than 2.00 rad/s, which its positions contradict");
  EXPECT_EQ(cause([](ArmSession& s) {
              ArmStatus status = at(1'252'000);
              status.external[2] = -25.0;
              s.receive(status, 0.252);
            }),
            "an external torque of 25.0 Nm acts on joint 3, more than 20.0 Nm");
  EXPECT_EQ(cause([](ArmSession& s) { s.receive(at(1'351'000), 0.252); }),
            "the arm's clock jumped by 0.100 s; at most 0.020 s may lie between two statuses");
  EXPECT_EQ(cause([](ArmSession& s) {
              for (int i = 0; i <= ArmSession::kMostOld; ++i) s.receive(at(1'001'000), 0.252);
            }),
            "the arm's clock went back by 0.250 s and stayed there");
  EXPECT_EQ(cause([](ArmSession& s) {
              s.receive(at(1'252'000, std::numeric_limits<double>::quiet_NaN()), 0.252);
            }),
            "the arm's status has numbers that are not finite");
  EXPECT_EQ(cause([](ArmSession& s) {
              s.receive(at(1'252'000), 0.252);
              s.answer(all(std::numeric_limits<double>::infinity()));
            }),
            "the controller's torque is not finite");
}

// Runs a session with zero torque over statuses q(t), v(t), 1 ms apart for at most 2 s, and returns
// the cause. Once it has one, no torque may be larger than `most`, and zero is the last.
std::string told(const std::function<void(double t, ArmStatus*)>& arm, double most,
                 double wanted = 0.0, double step = 1e-3) {
  ArmSession session = begun();
  double now = 0.25;
  for (double t = step; t < 2.0 && session.state() != SessionState::ended; t += step) {
    ArmStatus status = at(1'250'000 + std::llround(1e6 * t));
    arm(t, &status);
    if (!session.receive(status, now += step)) continue;
    const double before = session.sent().cwiseAbs().maxCoeff();
    const double sent = session.answer(all(wanted)).cwiseAbs().maxCoeff();
    if (!session.cause().empty()) {
      EXPECT_LE(sent, std::max(before, most) + 1e-9) << t;
    }
  }
  if (!session.cause().empty()) {
    EXPECT_EQ(session.state(), SessionState::ended);
    EXPECT_TRUE(session.sent().isZero(0.0));
  }
  return session.cause();
}

TEST(ArmSession, AnArmThatLiesIsNamedAndNotDampedByItsLie) {
  const auto wave = [](double t, ArmStatus* s) {  // from rest, at most 0.6 rad/s
    s->q = all(0.1 * (1.0 - std::cos(6.0 * t)));
    s->v = all(0.6 * std::sin(6.0 * t));
  };
  EXPECT_EQ(told(wave, 0.0), "");
  EXPECT_THAT(told([](double t, ArmStatus* s) { s->q[1] = t > 0.5 ? 0.5 : 0.0; }, 1e-9),
              HasSubstr("the position of joint 2 jumped by 0.500 rad"));
  EXPECT_THAT(told([](double t, ArmStatus* s) { s->q[2] = 0.2 * t; }, 1e-9),
              HasSubstr("the speed of joint 3 has been 0.000 rad/s"));
  EXPECT_THAT(told([](double t, ArmStatus* s) { s->v[0] = t > 0.5 ? 9.0 : 0.0; }, 1e-9),
              HasSubstr("which its positions contradict"));
  const auto lying = [&](double q, double v) {
    return [=](double t, ArmStatus* s) {
      wave(t, s);
      s->q *= q;
      s->v *= v;
    };
  };
  EXPECT_THAT(told(lying(1.0, -1.0), 1e-9), HasSubstr("contradict its speed"));
  EXPECT_THAT(told(lying(57.296, 1.0), 3.0), HasSubstr("joint 1"));
  EXPECT_THAT(told(lying(1.0, 1000.0), 3.0), HasSubstr("joint 1"));
  EXPECT_THAT(told([](double, ArmStatus*) {}, 0.0, 15.0), HasSubstr("the arm does not move"));
}

// As `arm hold` does: zero torque to an arm that rests, with one false reading of a speed.
TEST(ArmSession, OneFalseSpeedWhileHoldingIsNamedAndDampsNothing) {
  for (const double speed : {2.5, 9.0, -9.0, 1000.0}) {
    ArmSession session = begun();
    session.hold();
    for (int ms = 1; ms < 1000 && session.state() != SessionState::ended; ++ms) {
      ArmStatus status = at(1'250'000 + 1000 * ms);
      if (ms == 100) status.v[1] = speed;
      if (session.receive(status, 0.25 + 1e-3 * ms)) session.answer(all(0.0));
      ASSERT_TRUE(session.sent().isZero(0.0)) << speed << " rad/s, " << ms << " ms";
    }
    EXPECT_EQ(session.state(), SessionState::ended);
    EXPECT_THAT(session.cause(), HasSubstr("which its positions contradict")) << speed;
  }
}

// What real arms say: encoders of 17 bits, speeds 10 ms late, statuses that are lost.
TEST(ArmSession, AnArmThatIsOnlyCoarseIsBelieved) {
  for (const double step : {1e-3, 5e-3, 1.0 / 60.0}) {
    SCOPED_TRACE(step);
    std::mt19937 random(7);
    std::bernoulli_distribution lost(step < 2e-3 ? 0.2 : 0.0);
    const double quantum = 2.0 * 3.14159265358979 / 131072.0;
    const auto coarse = [&](double t, ArmStatus* s) {
      s->q = all(quantum * std::round(0.3 * (1.0 - std::cos(6.0 * t)) / quantum));
      s->v = all(1.8 * std::sin(6.0 * std::max(0.0, t - 0.01)));
      if (lost(random)) s->utime = 0;  // older than the last: not taken
    };
    EXPECT_EQ(told(coarse, 0.0, 0.0, step), "");
  }
}

TEST(ArmSession, NoClockOverflows) {
  const std::int64_t least = std::numeric_limits<std::int64_t>::min(),
                     most = std::numeric_limits<std::int64_t>::max();
  EXPECT_NEAR(seconds_between(least, most), 1.8446744073709551e13, 1e4);
  EXPECT_EQ(seconds_between(most - 1000, most), 1e-3);
  EXPECT_EQ(seconds_between(most, most - 1000), -1e-3);
  ArmSession session(settings());
  session.receive(at(least), 0.0);
  session.receive(at(most), 0.001);
  EXPECT_THAT(session.cause(), HasSubstr("the arm's clock jumped by"));
  EXPECT_EQ(session.state(), SessionState::ended);
  EXPECT_EQ(session.missed(), 0);
}

TEST(ArmSession, BeforeTheFirstCommandAFaultLeavesNothingToTakeBack) {
  ArmSession session(settings());
  session.receive(at(1), 0.0);
  session.fail("somebody says no");
  EXPECT_EQ(session.state(), SessionState::ended);
  EXPECT_FALSE(session.sent_any());
  EXPECT_EQ(session.cause(), "somebody says no");
}

TEST(ArmSession, BadSettingsAreRefused) {
  SessionSettings s = settings();
  s.damping = nullptr;
  EXPECT_THROW(ArmSession{s}, std::invalid_argument);
  s = settings();
  s.external_limit = all(1.0).head(2);
  EXPECT_THROW(ArmSession{s}, std::invalid_argument);
}

// Any order of messages, gaps, duplicates, clock jumps, requests and torques.
TEST(ArmSession, AnythingMayHappen) {
  for (unsigned seed = 0; seed < seeds(200, 5000); ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto uniform = [&](double a, double b) {
      return std::uniform_real_distribution<double>(a, b)(random);
    };
    const auto chance = [&](double p) { return uniform(0.0, 1.0) < p; };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    ArmSession session(settings());
    const double trouble = chance(0.5) ? 0.0 : 0.02;
    std::int64_t utime = 5, newest = 0, first = -1;
    double now = 0.0, first_now = 0.0;
    JointVector before = all(0.0);
    bool faulted = false, was_ended = false;
    for (int i = 0; i < 1500; ++i) {
      now += chance(trouble) ? uniform(0.0, 0.2) : 1e-3;
      utime += chance(trouble) ? static_cast<std::int64_t>(uniform(-1e5, 1e5))
                               : (chance(0.05) ? 0 : 1000);
      ArmStatus status = at(utime, uniform(-1.0, 1.0) * (chance(trouble) ? 5.0 : 1.0));
      if (chance(0.1 * trouble)) status.q[1] = nan;
      if (chance(0.1 * trouble)) status.external[0] = uniform(-50.0, 50.0);
      if (first < 0) {
        first = utime;
        first_now = now;
      }
      const bool answer = session.receive(status, now);
      if (answer) {
        EXPECT_GT(utime, newest);
        EXPECT_GE(now - first_now, 0.25);
        EXPECT_GE(utime - first, 250'000);
      }
      newest = std::max(newest, utime);
      if (chance(0.3)) session.tick(now);
      if (chance(0.002)) session.hold();
      if (chance(0.002)) session.run();
      if (chance(0.0005)) session.stop();
      if (answer || chance(0.01)) {
        const bool could = session.may_send();
        JointVector wanted = all(uniform(-80.0, 80.0));
        if (chance(0.1 * trouble)) wanted[2] = nan;
        const JointVector tau = session.answer(wanted, !answer);
        ASSERT_TRUE(tau.allFinite());
        ASSERT_LE(tau.cwiseAbs().maxCoeff(), 40.0);
        ASSERT_LE((tau - before).cwiseAbs().maxCoeff(),
                  900.0 * SessionSettings().longest_step + 1e-12);
        if (!could) {
          ASSERT_EQ(tau, before);
        }
        before = tau;
      }
      ASSERT_STRNE(name_of(session.state()), "");
      // A fault is for good, and ended is ended.
      const bool ended = session.state() == SessionState::ended;
      if (faulted) {
        ASSERT_TRUE(session.state() == SessionState::fault || ended);
      }
      if (was_ended) {
        ASSERT_TRUE(ended);
      }
      faulted = faulted || session.state() == SessionState::fault;
      was_ended = ended;
      if (ended) {
        ASSERT_TRUE(session.sent().isZero(0.0));
      }
      if (session.state() == SessionState::fault) {
        ASSERT_FALSE(session.cause().empty());
      }
    }
    // However it stands, it can be brought to an end without any further status.
    session.stop();
    for (int i = 0; i < 200 && session.may_send(); ++i) session.answer(all(1.0), true);
    ASSERT_FALSE(session.may_send());
    ASSERT_TRUE(session.sent().isZero(0.0));
  }
}

// Every motion decays at the same rate: for random inertias, as far from diagonal as they come.
TEST(DampingTorque, BringsJointsThatTurnTogetherToRestAsItDoesEachAlone) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    const int n = 7;
    Eigen::MatrixXd A = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
    A.col(0) *= 10.0;
    const JointMatrix M = A * A.transpose() + 1e-3 * Eigen::MatrixXd::Identity(n, n);
    const Eigen::VectorXd v = Eigen::VectorXd::NullaryExpr(n, [&] { return normal(random); });
    const Eigen::VectorXd vdot =
        Eigen::MatrixXd(M).ldlt().solve(Eigen::VectorXd(damping_torque(M, v)));
    EXPECT_LT((vdot + kDampRate * v).norm(), 1e-6 * vdot.norm());
  }
}

}  // namespace
}  // namespace impedraw

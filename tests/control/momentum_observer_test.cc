// The momentum observer against a plant that this test integrates: its estimate is the disturbance
// through a first-order low-pass.
#include "impedraw/control/momentum_observer.h"

#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "arm_fixture.h"
#include "dense_algebra.h"
#include "impedraw/common/errors.h"
#include "impedraw/control/disturbance.h"

namespace impedraw {
namespace {

using namespace testing_arm;

constexpr double kDt = 1e-3;

ObserverSettings observer_of(double bandwidth, double limit = 1e3) {
  ObserverSettings s;
  s.bandwidth = bandwidth;
  s.limit = limit;
  return s;
}

JointVector some_torque(double scale) {
  JointVector d(7);
  d << 4.0, -3.0, 2.0, 1.5, -1.0, 0.8, -0.4;
  return scale * d;
}

// M v̇ + C v + g = τ + Jᵀ F + d, semi-implicit Euler with `substeps` per step. Its own controller
// moves it to q_0 and around it.
struct Plant {
  ArmModel arm{kArm};
  ArmTerms terms{7};
  JointVector q = working_posture(), v = JointVector::Zero(7);
  int substeps = 1;

  Plant() { arm.compute(q, v, &terms); }

  JointVector moving_torque(double t) const {
    JointVector wave(7);
    for (int j = 0; j < 7; ++j) wave[j] = 6.0 * std::sin((2.0 + 0.7 * j) * t + j);
    return terms.g +
           terms.M.diagonal().cwiseProduct(25.0 * (working_posture() - q) - 6.0 * v + wave);
  }

  void step(const JointVector& tau, const Vector6& F, const JointVector& d) {
    const double h = kDt / substeps;
    for (int i = 0; i < substeps; ++i) {
      const JointVector force = tau + terms.J.transpose() * F + d - terms.Cv - terms.g;
      v += h * solve(terms.M, force);
      q += h * v;
      arm.compute(q, v, &terms);
    }
  }
};

using WrenchAt = std::function<Vector6(double)>;

// r after each of `steps`, for a plant whose torque and measured wrench are delayed by the given
// number of steps.
std::vector<JointVector> observe(MomentumObserver& observer, Plant& plant, int steps,
                                 const WrenchAt& wrench, const JointVector& d, int torque_late = 0,
                                 int wrench_late = 0) {
  std::vector<JointVector> r, commands;
  const JointVector first = plant.moving_torque(0.0);
  for (int i = 0; i < steps; ++i) {
    // The newest wrench is the mean over the step that has just ended.
    r.push_back(observer.update(plant.terms, wrench((i - 1 - wrench_late) * kDt)));
    commands.push_back(plant.moving_torque(i * kDt));
    observer.commanded(commands.back());
    plant.step(i < torque_late ? first : commands[static_cast<std::size_t>(i - torque_late)],
               wrench(i * kDt), d);
  }
  return r;
}

Vector6 no_wrench(double) { return Vector6::Zero(); }

Vector6 waving_wrench(double t) {
  Vector6 F;
  F << 8.0 * std::sin(40.0 * t), 5.0 * std::cos(55.0 * t), 6.0 + 4.0 * std::sin(70.0 * t),
      0.3 * std::sin(30.0 * t), 0.2, -0.1;
  return F;
}

double worst(const std::vector<JointVector>& r, const JointVector& d, int from) {
  double worst = 0.0;
  for (std::size_t i = static_cast<std::size_t>(from); i < r.size(); ++i)
    worst = std::max(worst, (r[i] - d).cwiseAbs().maxCoeff());
  return worst;
}

TEST(MomentumObserver, FollowsTheDisturbanceAsALowPassOfItsBandwidth) {
  const JointVector d = some_torque(1.0);
  for (const double bandwidth : {50.0, 200.0, 400.0}) {
    MomentumObserver observer(observer_of(bandwidth), 7, kDt, 0.0, 0.0);
    Plant plant;
    const std::vector<JointVector> r = observe(observer, plant, 200, no_wrench, d);
    for (int i = 0; i < 200; ++i) {
      const double risen = 1.0 - std::exp(-bandwidth * i * kDt);
      ASSERT_LT((r[static_cast<std::size_t>(i)] - risen * d).norm(), 1e-9)
          << "at " << i << " ms, bandwidth " << bandwidth;
    }
    EXPECT_GT(plant.v.norm(), 0.1) << "or Coriolis torque was not in it";
  }
}

TEST(MomentumObserver, BearsAPlantThatIsNotSampledAsItIs) {
  const JointVector d = some_torque(1.0);
  MomentumObserver observer(observer_of(200.0), 7, kDt, 0.0, 0.0);
  Plant plant;
  plant.substeps = 20;
  const std::vector<JointVector> r = observe(observer, plant, 400, waving_wrench, d);
  EXPECT_LT(worst(r, d, 100), 0.05 * d.cwiseAbs().maxCoeff())
      << "the wrench turns by 7 % a step, the posture by 1 mrad";
}

TEST(MomentumObserver, NeedsNothingWhereTheModelIsRight) {
  MomentumObserver observer(observer_of(200.0), 7, kDt, 0.0, 0.0);
  Plant plant;
  EXPECT_LT(worst(observe(observer, plant, 500, no_wrench, JointVector::Zero(7)),
                  JointVector::Zero(7), 0),
            1e-9);
}

TEST(MomentumObserver, ItsArmsOwnTorqueHasNoEffect) {
  const unsigned seed = 31;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  MomentumObserver observer(observer_of(400.0), 7, kDt, 0.0, 0.0);
  Plant plant;
  for (int i = 0; i < 500; ++i) {
    ASSERT_LT(observer.update(plant.terms, Vector6::Zero()).cwiseAbs().maxCoeff(), 1e-8)
        << "at " << i << " ms";
    JointVector tau = plant.moving_torque(i * kDt);  // jerky: 100 rad/s² of noise on every joint
    for (int j = 0; j < 7; ++j) tau[j] += 100.0 * plant.terms.M(j, j) * normal(rng);
    observer.commanded(tau);
    plant.step(tau, Vector6::Zero(), JointVector::Zero(7));
  }
}

TEST(MomentumObserver, IsBoundedAndDoesNotWindUp) {
  const double bandwidth = 100.0, limit = 10.0;
  MomentumObserver observer(observer_of(bandwidth, limit), 7, kDt, 0.0, 0.0);
  Plant plant;
  JointVector d = JointVector::Zero(7);
  d[0] = 500.0;
  d[1] = -300.0;
  // Ten time constants of a disturbance far beyond the limit. An equal torque, unknown to the
  // observer, brakes the arm.
  for (int i = 0; i < 100; ++i) {
    const JointVector& r = observer.update(plant.terms, Vector6::Zero());
    ASSERT_LE(r.cwiseAbs().maxCoeff(), limit);
    const JointVector tau = plant.moving_torque(i * kDt);
    observer.commanded(tau - d);
    plant.step(tau - d, Vector6::Zero(), d);
  }
  ASSERT_EQ(observer.disturbance()[0], limit);
  ASSERT_EQ(observer.disturbance()[1], -limit);
  const std::vector<JointVector> r = observe(observer, plant, 60, no_wrench, JointVector::Zero(7));
  // The step that ends now still had d in it; from then on r falls from the limit at once. An
  // integral that only its output bounds would stay at the limit for ln(500/10) = 3.9 time
  // constants more.
  for (std::size_t i = 1; i < r.size(); ++i) {
    const double left = limit * std::exp(-bandwidth * static_cast<double>(i) * kDt);
    ASSERT_NEAR(r[i][0], left, 1e-9) << "after " << i << " ms";
    ASSERT_NEAR(r[i][1], -left, 1e-9) << "after " << i << " ms";
  }
}

TEST(MomentumObserver, PutsALateTorqueBesideTheMotionItMade) {
  const JointVector d = some_torque(0.5);
  for (const int late : {1, 3, 8}) {
    MomentumObserver told(observer_of(200.0), 7, kDt, 0.0, late * kDt),
        not_told(observer_of(200.0), 7, kDt, 0.0, 0.0);
    Plant plant, same;
    EXPECT_LT(worst(observe(told, plant, 400, no_wrench, d, late), d, 100), 1e-6)
        << late << " steps late";
    EXPECT_GT(worst(observe(not_told, same, 400, no_wrench, d, late), d, 100), 0.01)
        << "or the delay would not matter: the test is blind";
  }
}

TEST(MomentumObserver, PutsALateWrenchBesideTheMotionItMade) {
  const JointVector d = some_torque(0.5);
  for (const int late : {1, 4, 10}) {
    MomentumObserver told(observer_of(200.0), 7, kDt, late * kDt, 0.0),
        not_told(observer_of(200.0), 7, kDt, 0.0, 0.0);
    Plant plant, same;
    // A late wrench meets the current Jacobian, although the arm has moved by v Δt late since.
    const double error_told = worst(observe(told, plant, 600, waving_wrench, d, 0, late), d, 200);
    const double error_not = worst(observe(not_told, same, 600, waving_wrench, d, 0, late), d, 200);
    EXPECT_LT(error_told, 0.02 * (late + 1)) << late << " steps late";
    EXPECT_GT(error_not, 5.0 * error_told) << late << " steps late: or the age would not matter";
  }
}

TEST(MomentumObserver, BothDelaysAtOnce) {
  const JointVector d = some_torque(0.5);
  MomentumObserver observer(observer_of(200.0), 7, kDt, 4 * kDt, 3 * kDt);
  Plant plant;
  EXPECT_LT(worst(observe(observer, plant, 600, waving_wrench, d, 3, 4), d, 200), 0.1);
}

// The law's settings tell all ages from now; a state that is read late is older than its torque's
// effect, and younger than a wrench that is later still.
TEST(MomentumObserver, IsToldTheAgesFromTheStateOn) {
  constexpr int kState = 2, kTorque = 3, kWrench = 6;  // [steps]
  const JointVector d = some_torque(0.5);
  const auto worst_told = [&](int state, int torque, int wrench) {
    ImpedanceSettings s;
    s.wrench = WrenchFeedback::measured;
    s.observer = observer_of(200.0);
    s.timing.dt = kDt;
    s.timing.loop_delay = (1 + torque) * kDt;
    s.timing.wrench_delay = (1 + wrench) * kDt;
    s.timing.velocity_age = state * kDt;
    Disturbance disturbance(s, 7);
    OperationalSpace space;
    Plant plant;
    std::vector<ArmTerms> states;
    std::vector<JointVector> r, commands;
    const JointVector first = plant.moving_torque(0.0);
    for (int i = 0; i < 600; ++i) {
      states.push_back(plant.terms);
      const TipReference reference;
      const SurfaceEstimate surface;
      const StepInput in{states[static_cast<std::size_t>(std::max(0, i - kState))],
                         reference,
                         surface,
                         waving_wrench((i - 1 - kWrench) * kDt),
                         false,
                         nullptr};
      r.push_back(-disturbance.compensation(in, space));
      commands.push_back(plant.moving_torque(i * kDt));
      disturbance.commanded(in, commands.back());
      plant.step(i < kTorque ? first : commands[static_cast<std::size_t>(i - kTorque)],
                 waving_wrench(i * kDt), d);
    }
    return worst(r, d, 200);
  };
  const double told = worst_told(kState, kTorque, kWrench);
  EXPECT_LT(told, 0.1);
  EXPECT_GT(worst_told(0, kTorque, kWrench), 2.0 * told);
  EXPECT_GT(worst_told(kState, kTorque - 2, kWrench), 1.2 * told);
  EXPECT_GT(worst_told(kState, kTorque, kWrench - 2), 2.0 * told);
}

TEST(MomentumObserver, ForgetsOnReset) {
  MomentumObserver observer(observer_of(200.0), 7, kDt, 2 * kDt, kDt);
  Plant plant;
  observe(observer, plant, 100, no_wrench, some_torque(1.0), 1, 2);
  ASSERT_GT(observer.disturbance().norm(), 1.0);
  observer.reset();
  EXPECT_EQ(observer.disturbance().norm(), 0.0);
  // Another posture and velocity, as after a pause. The change must not count as motion under
  // torque.
  Plant other;
  other.q[1] += 0.5;
  other.v = JointVector::Constant(7, 0.8);
  other.arm.compute(other.q, other.v, &other.terms);
  EXPECT_LT(worst(observe(observer, other, 200, no_wrench, JointVector::Zero(7), 1, 2),
                  JointVector::Zero(7), 0),
            1e-6);
}

TEST(MomentumObserver, RefusesWhatItCannotKeepOrReach) {
  EXPECT_THROW(MomentumObserver(observer_of(0.0), 7, kDt, 0.0, 0.0), InputError);
  EXPECT_THROW(MomentumObserver(observer_of(200.0, -1.0), 7, kDt, 0.0, 0.0), InputError);
  EXPECT_THROW(MomentumObserver(observer_of(200.0), 7, kDt, 0.1, 0.0), InputError);
  EXPECT_THROW(MomentumObserver(observer_of(200.0), 7, kDt, 0.0, 0.1), InputError);
  EXPECT_THROW(MomentumObserver(observer_of(200.0), 7, kDt, -kDt, 0.0), InputError);
  EXPECT_NO_THROW(MomentumObserver(observer_of(200.0), 7, kDt, 30 * kDt, 30 * kDt));
  EXPECT_THROW(MomentumObserver(observer_of(200.0), 7, kDt, 31 * kDt, 0.0), InputError);
  EXPECT_THROW(MomentumObserver(observer_of(std::nan("")), 7, kDt, 0.0, 0.0), InputError);
}

// Rotors that the model has are no disturbance; those that it lacks are all that is felt of them.
TEST(MomentumObserver, KnowsTheRotorsThatTheModelHas) {
  for (const double known : {0.2, 0.0}) {
    SCOPED_TRACE(known);
    Plant plant;
    plant.arm.set_rotor_inertia({0.2});
    plant.arm.compute(plant.q, plant.v, &plant.terms);
    ArmModel model(kArm);
    model.set_rotor_inertia({known});
    ArmTerms terms(7);
    MomentumObserver observer(observer_of(200.0), 7, kDt, 0.0, 0.0);
    double most = 0.0;
    for (int i = 0; i < 1000; ++i) {
      model.compute(plant.q, plant.v, &terms);
      most = std::max(most, observer.update(terms, Vector6::Zero()).cwiseAbs().maxCoeff());
      const JointVector tau = plant.moving_torque(kDt * i);
      observer.commanded(tau);
      plant.step(tau, Vector6::Zero(), JointVector::Zero(7));
    }
    if (known > 0.0)
      EXPECT_LT(most, 1e-6);
    else
      EXPECT_GT(most, 0.3);
  }
}

}  // namespace
}  // namespace impedraw

// The settings: defaults for any number of joints, refusals that name the fault, and one value for
// the delay of the loop.
#include "impedraw/control/impedance_settings.h"

#include <cmath>
#include <functional>
#include <string>

#include <gmock/gmock.h>

#include "free_arm.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using namespace testing_arm;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string refusal(const ImpedanceSettings& s, int joints = 7) {
  try {
    s.validate(joints);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ImpedanceSettings, DefaultsServeAnyNumberOfJoints) {
  for (int joints = 1; joints <= kMaxJoints; ++joints) {
    EXPECT_EQ(refusal({}, joints), "accepted") << joints;
    const ImpedanceSettings s = ImpedanceSettings().completed(joints);
    EXPECT_EQ(s.null_space.stiffness, Eigen::VectorXd::Constant(joints, 10.0));
    EXPECT_EQ(s.null_space.q_0, Eigen::VectorXd::Zero(joints));
    EXPECT_EQ(s.limits.torque, Eigen::VectorXd::Constant(joints, 1000.0));
    EXPECT_EQ(s.limits.torque_rate.size(), 0);
    EXPECT_EQ(refusal(s, joints), "accepted");
  }
  EXPECT_THAT(refusal({}, 0), HasSubstr("the number of joints is 0"));
  EXPECT_THAT(refusal({}, kMaxJoints + 1), HasSubstr("the number of joints is 13"));
}

TEST(ImpedanceSettings, AJointRestsInTheMiddleOfItsRangeUnlessToldOtherwise) {
  ImpedanceSettings s;
  s.joint_range.lower = Eigen::VectorXd::Constant(6, -3.0);
  s.joint_range.upper = Eigen::VectorXd::Constant(6, -0.2);  // as the elbow of some arms has it
  EXPECT_EQ(s.completed(6).null_space.q_0, Eigen::VectorXd::Constant(6, -1.6));
  s.null_space.q_0 = Eigen::VectorXd::Constant(6, -1.0);
  EXPECT_EQ(s.completed(6).null_space.q_0, s.null_space.q_0);
}

TEST(ImpedanceSettings, DefaultsLeftEmptyActAsTheSameValuesGiven) {
  ArmModel arm(kArm);
  std::mt19937 rng(5);
  const ImpedanceSettings s;
  ImpedanceController left_out(s, 7), given(s.completed(7), 7);
  for (int i = 0; i < 20; ++i) {
    const ArmTerms terms = random_terms(arm, rng);
    TipReference reference;
    reference.p_WD = terms.X_WE.p;
    reference.n_WD = -terms.X_WE.R.col(2);
    EXPECT_EQ(left_out.step(terms, reference, {}, Wrench::Zero()).tau,
              given.step(terms, reference, {}, Wrench::Zero()).tau);
  }
}

TEST(ImpedanceSettings, ARefusalNamesSettingAndValue) {
  using S = ImpedanceSettings;
  const double nan = std::nan("");
  const struct {
    const char *name, *value;
    std::function<void(S&)> spoil;
  } cases[] = {
      {"control.dt is", "0 s", [](S& s) { s.timing.dt = 0.0; }},
      {"control.loop_delay is", "-0.001 s", [](S& s) { s.timing.loop_delay = -1e-3; }},
      {"control.wrench_delay is", "nan", [=](S& s) { s.timing.wrench_delay = nan; }},
      {"control.max_state_age is", "-1 s", [](S& s) { s.timing.max_state_age = -1.0; }},
      {"control.stiffness_tangent is", "-5 N/m", [](S& s) { s.stiffness.linear.tangent = -5.0; }},
      {"control.rotational_inertia_normal is", "0 kg m²",
       [](S& s) { s.shaped_inertia.angular.normal = 0.0; }},
      {"control.damping_ratio is", "0, ", [](S& s) { s.damping_ratio = 0.0; }},
      {"control.drawing_axis_W length is", "2", [](S& s) { s.surface.drawing_axis_W *= 2.0; }},
      {"control.min_axis_cosine is", "1.5", [](S& s) { s.surface.min_axis_cosine = 1.5; }},
      {"control.normal_bandwidth is", "0 rad/s", [](S& s) { s.surface.normal_bandwidth = 0.0; }},
      {"control.approach_speed is", "0 m/s", [](S& s) { s.approach.speed = 0.0; }},
      {"control.approach_lag is", "-0.1 m", [](S& s) { s.approach.lag = -0.1; }},
      {"control.contact.leave_distance is", "0 m", [](S& s) { s.contact.leave_distance = 0.0; }},
      {"control.tip_radius is", "-0.001 m", [](S& s) { s.tip.radius = -1e-3; }},
      {"control.friction is", "-0.3", [](S& s) { s.friction.coefficient = -0.3; }},
      {"control.fade_speed is", "0 m/s", [](S& s) { s.friction.fade_speed = 0.0; }},
      {"control.observer.bandwidth is", "0 rad/s", [](S& s) { s.observer.bandwidth = 0.0; }},
      {"control.force_integral.limit is", "-1 N", [](S& s) { s.force_integral.limit = -1.0; }},
      {"control.natural_mass_max is", "0 kg",
       [](S& s) { s.stability_check.natural_mass_max = 0.0; }},
      {"control.null_stiffness", "6 entries",
       [](S& s) { s.null_space.stiffness = Eigen::VectorXd::Ones(6); }},
      {"null_space.q_0", "nan",
       [=](S& s) { s.null_space.q_0 = Eigen::VectorXd::Constant(7, nan); }},
      {"joint_range.upper", "without the other",
       [](S& s) { s.joint_range.lower = Eigen::VectorXd::Ones(7); }},
      {"control.limit_margin is", "0 rad", [](S& s) { s.joint_range.margin = 0.0; }},
      {"limits.torque is", "-1 Nm", [](S& s) { s.limits.torque = -Eigen::VectorXd::Ones(7); }},
      {"control.torque_rate", "8 entries",
       [](S& s) { s.limits.torque_rate = Eigen::VectorXd::Ones(8); }},
      {"control.tip_speed_limit is", "inf", [](S& s) { s.limits.tip_speed = INFINITY; }},
      {"inertia 'shaped'", "measured wrench", [](S& s) { s.wrench = WrenchFeedback::none; }},
      {"along the normal", "unstable", [](S& s) { s.timing.wrench_delay = 10e-3; }},
  };
  for (const auto& c : cases) {
    ImpedanceSettings s;
    c.spoil(s);
    EXPECT_THAT(refusal(s), AllOf(HasSubstr(c.name), HasSubstr(c.value)));
    EXPECT_THROW(ImpedanceController(s, 7), InputError) << c.name;
  }
}

// The largest component of r over half a second of motion in the air, with an exact model and a
// torque that acts `steps_late` late.
double unexplained(double loop_delay, int steps_late) {
  ArmModel arm(kArm);
  ImpedanceSettings s = shaped_settings(arm);
  s.inertia = InertiaShaping::natural;
  s.stiffness = {{300.0, 200.0}, {5.0, 0.0}};
  s.reference_stiffness = {{300.0, 200.0}, {5.0, 2.0}};
  s.timing.loop_delay = loop_delay;
  WorldSettings world = FreeArm::at_step(s.timing.dt);
  world.errors.loop_delay = steps_late * s.timing.dt;
  FreeArm free(s, working_posture(), world);
  free.reference.p_WD += Eigen::Vector3d(0.02, -0.01, 0.01);
  double largest = 0.0;
  for (int i = 0; i < 500; ++i)
    largest = std::max(largest, free.step().terms.col(kDisturbance).cwiseAbs().maxCoeff());
  return largest;
}

TEST(LoopDelay, TheObserverPutsATorqueWhereTheLoopDelayHasItAct) {
  for (const int late : {0, 1, 4}) {
    EXPECT_LT(unexplained((1 + late) * 1e-3, late), 1e-6) << late << " steps late";
    EXPECT_GT(unexplained((2 + late) * 1e-3, late), 0.1) << "told another delay";
  }
}

TEST(LoopDelay, TheSameDelayBoundsTheDamping) {
  ArmModel arm(kArm);
  for (const double late : {0.0, 8e-3}) {
    ImpedanceSettings s = natural_settings(arm);
    s.timing.loop_delay = 1e-3 + late;
    FreeArm free(s);
    EXPECT_EQ(free.step().status.damping_limit, late > 0.0);
    ImpedanceSettings shaped = shaped_settings(arm);
    shaped.timing.loop_delay = 1e-3 + late;
    EXPECT_EQ(refusal(shaped) == "accepted", late == 0.0);
  }
}

// A velocity that comes late, or from an estimator that lags, counts as the loop's own delay does.
TEST(VelocityDelay, BoundsTheDampingAndTheInertiaInContact) {
  ArmModel arm(kArm);
  for (double TimingSettings::*delay :
       {&TimingSettings::velocity_age, &TimingSettings::velocity_lag}) {
    for (const double late : {0.0, 8e-3}) {
      ImpedanceSettings s = natural_settings(arm);
      s.timing.*delay = late;
      FreeArm free(s);
      EXPECT_EQ(free.step().status.damping_limit, late > 0.0);
      ImpedanceSettings shaped = shaped_settings(arm);
      shaped.timing.*delay = late;
      EXPECT_EQ(refusal(shaped) == "accepted", late == 0.0);
    }
    // With a damping that its rate alone would allow.
    ImpedanceSettings light = shaped_settings(arm);
    light.shaped_inertia.linear.normal = 3.0;
    light.stiffness = {{300.0, 1500.0}, {5.0, 0.0}};
    light.reference_stiffness = {{300.0, 1500.0}, {5.0, 1.0}};
    ASSERT_EQ(refusal(light), "accepted");
    light.timing.*delay = 10e-3;
    EXPECT_THAT(refusal(light), AllOf(HasSubstr("along the normal"), HasSubstr("unstable")));
  }
}

TEST(ImpedanceSettings, DampingIsDesignedForTheStiffnessOrWhereThereIsNoneForItsReference) {
  const auto values = [](const TipGain& k) {
    return std::vector<double>{k.linear.tangent, k.linear.normal, k.angular.tangent,
                               k.angular.normal};
  };
  ImpedanceSettings s;
  s.stiffness = {{1.0, 2.0}, {3.0, 4.0}};
  s.reference_stiffness = {{5.0, 6.0}, {7.0, 8.0}};
  EXPECT_THAT(values(s.damping_stiffness()), testing::ElementsAre(1.0, 2.0, 3.0, 4.0));
  s.stiffness = {{0.0, 0.0}, {0.0, 0.0}};
  EXPECT_THAT(values(s.damping_stiffness()), testing::ElementsAre(5.0, 6.0, 7.0, 8.0));
}

}  // namespace
}  // namespace impedraw

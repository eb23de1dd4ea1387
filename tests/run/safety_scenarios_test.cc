// Each scenario safety-* provokes one fault. Tests the arm's reaction.
#include <algorithm>

#include <gmock/gmock.h>

#include "drawn_scenario.h"
#include "impedraw/control/contact_mode.h"

namespace impedraw {
namespace {

const int kContact = static_cast<int>(ContactMode::contact),
          kRetreat = static_cast<int>(ContactMode::retreat);

double met(const Figures& f, const char* what) {
  const auto it = f.outcome.met.find(what);
  return it == f.outcome.met.end() ? 0.0 : it->second;
}

constexpr double kRate = 4000.0 * (1.0 + 1e-9);  // control.torque_rate

double highest_force(const Figures& f) {
  double most = 0.0;
  for (const Eigen::Vector3d& force : f.run.contact_force) most = std::max(most, force.norm());
  return most;
}

bool ever(const Figures& f, int mode) {
  return std::find(f.run.mode.begin(), f.run.mode.end(), mode) != f.run.mode.end();
}

TEST(Safety, AStateThatIsNotANumberPasses) {
  const Figures f = draw_scenario("safety-nan-state");
  EXPECT_NEAR(met(f, "bad_input"), 0.05, 2e-3);
  EXPECT_LE(torque_rate(f), kRate);
  EXPECT_GT(f["contact_fraction"], 0.95) << "and it draws on";
  EXPECT_LT(highest_force(f), 8.0);
}

TEST(Safety, AStaleStateStopsTheRun) {
  const Figures f = draw_scenario("safety-stale-state", {}, RunEnd::stopped);
  EXPECT_NE(f.outcome.cause.find("stale"), std::string::npos) << f.outcome.cause;
  EXPECT_LE(torque_rate(f), kRate);
  EXPECT_LT(highest_force(f), 8.0);
}

TEST(Safety, AStaleWrenchLiftsThePen) {
  const Figures f = draw_scenario("safety-stale-wrench");
  EXPECT_GT(met(f, "stale_wrench"), 0.4);
  EXPECT_TRUE(ever(f, kRetreat));
  EXPECT_LE(torque_rate(f), kRate);
  EXPECT_LT(highest_force(f), 8.0);
  EXPECT_LT(f["contact_fraction"], 0.6) << "the rest of the stroke is not drawn without a wrench";
}

TEST(Safety, ALostCloudLiftsThePenAfterAWhile) {
  const Figures f = draw_scenario("safety-no-cloud");
  EXPECT_TRUE(ever(f, kRetreat));
  EXPECT_NEAR(met(f, "surface_lost"), 1.0, 0.01);
  EXPECT_LE(torque_rate(f), kRate);
  EXPECT_LT(highest_force(f), 8.0);
  // Drawing continues with the last normal for lost_surface_time: 0.25 s of a stroke of about 10 s.
  EXPECT_NEAR(f["contact_fraction"], 0.525, 0.01);
}

TEST(Safety, AStepThatTakesTooLongLiftsThePenAndStops) {
  const Figures f = draw_scenario("safety-slow-step", {}, RunEnd::stopped);
  EXPECT_NE(f.outcome.cause.find("too long"), std::string::npos) << f.outcome.cause;
  EXPECT_LE(torque_rate(f), kRate);
  EXPECT_LT(highest_force(f), 8.0);
  EXPECT_EQ(f.run.contact_force.back().norm(), 0.0) << "the pen is up";
}

TEST(Safety, LostContactIsMadeAgainGently) {
  const Figures f = draw_scenario("safety-lost-contact");
  int losses = 0;
  for (std::size_t i = 1; i < f.run.mode.size(); ++i)
    losses += f.run.mode[i - 1] == kContact && f.run.mode[i] != kContact && f.run.stroke[i] >= 0;
  EXPECT_GE(losses, 1);
  EXPECT_GT(f["contact_fraction"], 0.85);
  EXPECT_LT(highest_force(f), 8.0);
  EXPECT_LE(torque_rate(f), kRate);
}

TEST(Safety, AJointIsKeptOffItsLimit) {
  const Figures f = draw_scenario("safety-joint-limit");
  EXPECT_GT(f["joint_margin_min"], 0.02);
  EXPECT_LE(f["ink_error_rms"], 0.04) << "the tip feels nothing of it";
  EXPECT_EQ(f["contact_fraction"], 1.0);
}

TEST(Safety, ATorqueLimitIsKeptAndThePenComesBack) {
  const Figures f = draw_scenario("safety-torque-limit");
  EXPECT_GT(met(f, "torque_limited"), 0.0);
  const double limit[] = {320, 320, 176, 176, 110, 40, 40};
  for (int j = 0; j < 7; ++j)
    EXPECT_LE(f.run.joint_torque.col(j).cwiseAbs().maxCoeff(), 0.3 * limit[j] + 1e-9)
        << "joint " << j + 1;
  EXPECT_LE(torque_rate(f), kRate);
  EXPECT_EQ(f["contact_fraction"], 1.0);
}

TEST(Safety, TheTipKeepsItsSpeedLimit) {
  const Figures f = draw_scenario("safety-speed-limit");
  EXPECT_GT(met(f, "speed_limited"), 0.1);
  double fastest = 0.0;
  for (std::size_t i = 1; i < f.run.rows(); ++i)
    fastest = std::max(fastest, (f.run.tip_position[i] - f.run.tip_position[i - 1]).norm() / 1e-3);
  EXPECT_LT(fastest, 0.25 * 1.05);
  EXPECT_GT(fastest, 0.2);
}

TEST(Safety, AStretchedArmLetsADirectionGo) {
  const Figures f = draw_scenario("safety-singular");
  EXPECT_GT(met(f, "near_singular"), 0.05);
  EXPECT_LE(torque_rate(f), kRate);
  EXPECT_EQ(f["torque_saturated"], 0.0);
  EXPECT_GE(f["contact_fraction"], 0.99);
}

// What the law cannot hold: the guard damps the motion long before 20 rad/s, lifts the pen and says
// why. The defects: joint 5 at 20 rad/s, the pen thrust into the canvas at 200 N, a lift by the law
// that had lost control, and a pen that hammered for a minute.
TEST(Safety, WhatTheLawCannotHoldIsDampedAndThePenLifted) {
  const struct {
    const char* scenario;
    std::vector<std::string> assignments;
    const char* cause;
    double force;  // greatest [N]
  } cases[] = {{"bowl-push",
                {"pushes.0.force=60", "control.torque_rate=900"},
                "torques at their limits",
                60},
               {"bowl-sine",
                {"world.errors.rotor_inertia=0.3", "control.check_rotors=false"},
                "above its speed limit",
                1},
               {"bowl-sine", {"world.errors.loop_delay=0.008"}, "torques at their limits", 1},
               // its first blow: 121 N with and without stiff_contact.h
               {"bowl-sine", {"world.tip.stiffness=2e6"}, "hammered on the canvas", 125}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.assignments.front());
    const Figures f = draw_scenario(c.scenario, c.assignments, RunEnd::stopped);
    EXPECT_THAT(f.outcome.cause, testing::HasSubstr(c.cause));
    EXPECT_THAT(f.outcome.cause, testing::HasSubstr("the motion was damped and the pen lifted by"));
    EXPECT_LT(f.run.joint_velocity.cwiseAbs().maxCoeff(), 9.0);
    EXPECT_LT(f.run.joint_velocity.bottomRows(1).cwiseAbs().maxCoeff(), 1.0);
    EXPECT_LT(highest_force(f), c.force);
    EXPECT_EQ(f.run.contact_force.back().norm(), 0.0);
  }
}

// A tip of up to twenty times the stiffness that the law was set up for: from 200 kN/m on the pen
// hammered.
TEST(Safety, ATipThatIsStifferThanBelievedIsBorne) {
  for (const char* stiffness : {"2e5", "5e5", "1e6"}) {
    SCOPED_TRACE(stiffness);
    const Figures f = draw_scenario("bowl-sine", {std::string("world.tip.stiffness=") + stiffness});
    EXPECT_GE(f["coverage"], 0.99);
    EXPECT_NEAR(f["force_mean"], 5.0, 0.05);
    EXPECT_LE(f["force_sd"], 0.5);
  }
}

// 400 N on the elbow for a quarter of a second, which the wrist does not feel: one motion that the
// guard damps, after which the arm draws as well as before. The defect: the guard ended the
// drawing, on a torus at one singular posture of the wrist.
TEST(Safety, AfterOneMotionThatTheGuardDampedTheDrawingGoesOn) {
  const std::string push =
      "{link: link_4, force: 200, direction: [0, 1, 0], middle: 0.5, "
      "duration: 0.25}";
  const Figures f = draw_scenario("bowl-push-elbow", {"pushes=[" + push + ", " + push + "]"});
  ASSERT_EQ(f.outcome.damped.size(), 1u);
  EXPECT_THAT(f.outcome.damped.front(), testing::HasSubstr("the motion was damped and the pen"));
  EXPECT_GE(f["coverage"], 0.99);
  EXPECT_LE(f["touchdown_peak"], 8.0);
  EXPECT_LE(f["ink_error_p95"], 0.05);
  EXPECT_LT(f.run.joint_velocity.cwiseAbs().maxCoeff(), 9.0);
}

// A ripple of every joint's torque, and friction of the wrist that keeps the pen from turning as
// fast as the law asks for. Joint 7 and joint 4 were thrown beyond their speed limits before the
// law had limits for them, and the guard ended the drawing.
TEST(Safety, TheLawHoldsJointsThatAreTooFast) {
  const std::vector<std::string> cases[] = {
      {"world.errors.torque_ripple=1"},
      {"world.errors.viscous_friction=4", "control.observer.enabled=false",
       "control.stiffness_tangent=3000", "control.rotational_stiffness_tangent=100"}};
  for (const std::vector<std::string>& assignments : cases) {
    SCOPED_TRACE(assignments.front());
    const Figures f = draw_scenario("bowl-sine", assignments);
    EXPECT_GE(f["contact_fraction"], 0.99);
    EXPECT_LE(f["touchdown_peak"], 8.0);
    EXPECT_LE(f["force_sd"], 0.5);
    if (assignments.size() > 1) {
      EXPECT_LE(f["joint_speed_share_max"], 1.1) << "2.4 before";
    }
  }
}

// Every change of mode in every standard drawing.
TEST(Safety, NoSwitchStepsTheTorque) {
  // The largest measured change between two steps at a switch [Nm]: at a touch, where the wrench
  // appears within one step, times Λ/M_d. A blind law has no contact states and never switches.
  const std::pair<const char*, double> all[] = {{"bowl-m", 1.56},
                                                {"bowl-m-natural", 0.068},
                                                {"bowl-m-blind", 0.0},
                                                {"bowl-m-realistic", 0.0458}};
  for (const auto& [name, measured] : all) {
    const Figures f = draw_scenario(name);
    double largest = 0.0;
    EXPECT_LE(torque_rate(f), kRate) << name;
    for (std::size_t i = 1; i < f.run.mode.size(); ++i) {
      if (f.run.mode[i] == f.run.mode[i - 1]) continue;
      const auto row = static_cast<int>(i);
      const double step =
          (f.run.joint_torque.row(row) - f.run.joint_torque.row(row - 1)).cwiseAbs().maxCoeff();
      EXPECT_LE(step, kRegression * measured)
          << name << ": from " << kContactModeNames[f.run.mode[i - 1]] << " to "
          << kContactModeNames[f.run.mode[i]];
      largest = std::max(largest, step);
    }
    RecordProperty(name, std::to_string(largest));
  }
}

}  // namespace
}  // namespace impedraw

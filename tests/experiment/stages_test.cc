// The stages of an experiment: each needs those before it and nothing else.
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/rotations.h"
#include "impedraw/experiment/page_of_plan.h"
#include "impedraw/experiment/plan_summary.h"
#include "impedraw/experiment/prepare.h"

namespace impedraw {
namespace {

Scenario scenario(const std::vector<std::string>& assignments) {
  DrawOptions options;
  options.scenario = "scenarios/bowl.yaml";
  options.assignments = assignments;
  return resolve(options);
}

// A shaped inertia without a wrench is refused by the controller, which a plan does not ask.
TEST(Stages, APlanNeedsNoController) {
  const Scenario s = scenario({"control.wrench=none", "control.inertia=shaped"});
  EXPECT_THROW(prepare(s), InputError);
  const PreparedPlan planned = prepare_plan(s);
  EXPECT_GT(planned.plan.path.duration(), 1.0);
  EXPECT_TRUE(planned.plan.preflight.findings.empty());
}

TEST(Stages, TheStrokesArePlacedOnceForAll) {
  const PreparedPlan e = prepare_plan(scenario({"drawing.svg=artwork/koi.svg"}));
  const std::vector<PlacedStroke> placed =
      placed_strokes(e.artwork.shape.drawn, e.artwork.placement);
  ASSERT_EQ(e.artwork.strokes.size(), placed.size());
  ASSERT_EQ(e.plan.source.size(), placed.size());
  EXPECT_FALSE(e.plan.laid) << "projected, it lies where it was placed";
  for (std::size_t i = 0; i < placed.size(); ++i) {
    EXPECT_EQ(e.artwork.strokes[i].p_P, placed[i].p_P);
    EXPECT_EQ(e.plan.source[i], static_cast<int>(i));
  }
}

// A face sinks in by tenths of a millimetre more or less than planned. Seen along z that is several
// times as much on a steep side, where it once slid off by 28 mm.
TEST(Stages, AFaceKeepsToThePlansHeightOnASteepSide) {
  const auto least = [](const std::vector<std::string>& assignments) {
    return prepare(scenario(assignments)).control.impedance.surface.min_axis_cosine;
  };
  EXPECT_EQ(least({}), SurfaceSettings().min_axis_cosine);
  EXPECT_EQ(least({"tool.kind=pad"}), 0.5);
}

// The default is light. A wrench that comes late asks for more, 1.3 times what is just stable;
// a mass that is given is taken as it is.
TEST(Stages, ThePenIsAsLightAsTheWrenchPermits) {
  const auto mass = [](const std::vector<std::string>& assignments) {
    return prepare(scenario(assignments)).control.impedance.shaped_inertia.linear.normal;
  };
  EXPECT_DOUBLE_EQ(mass({}), ImpedanceSettings().shaped_inertia.linear.normal);
  EXPECT_DOUBLE_EQ(mass({"control.mass_normal=2.5"}), 2.5);
  // On a canvas that moves 0.6 kg, or 1.3 times what this loop bears.
  const double moving = mass({"perception.frames.enabled=true", "perception.frames.depth=true"});
  EXPECT_GE(moving, 0.6);
  EXPECT_LT(moving, 0.8);
  double last = 0.0;
  for (const double delay : {0.0, 0.001, 0.002, 0.004}) {
    const std::vector<std::string> late = {"control.wrench=sensor",
                                           fmt::format("wrench_sensor.delay={}", delay)};
    const double chosen = mass(late);
    EXPECT_GE(chosen, std::max(1.5, last)) << delay;
    last = chosen;
    if (delay == 0.0) continue;
    EXPECT_GT(chosen, 1.5) << delay;
    std::vector<std::string> lighter = late;
    lighter.push_back(fmt::format("control.mass_normal={}", chosen / 1.4));
    EXPECT_THROW(prepare(scenario(lighter)), InputError) << delay;
  }
}

// Along the normal alone, as light as asked or as the loop is stable with, and never heavier than
// the arm is.
TEST(Stages, LightAlongTheNormalIsAsLightAsTheLoopBears) {
  double last = 0.1;
  for (const double delay : {0.0, 0.001, 0.002, 0.004, 0.02}) {
    const std::vector<std::string> late = {"control.wrench=sensor",
                                           fmt::format("wrench_sensor.delay={}", delay)};
    const auto scale = [&](const char* inertia, double asked) {
      std::vector<std::string> all = late;
      all.push_back(fmt::format("control.inertia={}", inertia));
      all.push_back(fmt::format("control.inertia_scale={}", asked));
      return prepare(scenario(all)).control.impedance.inertia_scale;
    };
    const double chosen = scale("light_normal", 0.1);
    EXPECT_GE(chosen, last) << delay;
    EXPECT_LE(chosen, 1.0) << delay;
    EXPECT_DOUBLE_EQ(scale("light_normal", 2.0), 2.0);
    if (chosen > 0.1 && chosen < 1.0) {
      EXPECT_THROW(scale("scaled", chosen / 1.4), InputError) << delay;
      EXPECT_DOUBLE_EQ(scale("scaled", chosen), chosen) << delay;
    }
    last = chosen;
  }
  EXPECT_GT(last, 0.2);
}

// Stage by stage comes to the same as all at once.
TEST(Stages, TheStagesAreThePreparation) {
  Scenario s = scenario({"drawing.shape=M"});
  const Prepared whole = prepare(s);
  const Places places;
  const SettingErrors setting_errors(places);
  const PlacedArtwork artwork = load_artwork(s.drawing, setting_errors);
  Scene scene = build_scene(s, artwork.X_WP, setting_errors);
  const Plan plan = make_plan(s, artwork, scene.belief, Unreachable::refuse, setting_errors);
  const ControlSetup control = make_control_setup(s, scene.belief, plan, setting_errors);
  EXPECT_EQ(plan.path.duration(), whole.plan.path.duration());
  EXPECT_EQ(control.impedance.null_space.q_0, whole.control.impedance.null_space.q_0);
  EXPECT_EQ(control.impedance.limits.torque, scene.belief.arm.limits().torque);
}

// Against the product written out.
TEST(RollPitchYaw, TurnsAboutXThenYThenZ) {
  const Eigen::Vector3d rpy(20.0, -35.0, 110.0);
  const Eigen::Vector3d a = rpy * std::numbers::pi / 180.0;
  const double cr = std::cos(a.x()), sr = std::sin(a.x()), cp = std::cos(a.y()),
               sp = std::sin(a.y()), cy = std::cos(a.z()), sy = std::sin(a.z());
  Eigen::Matrix3d R;
  R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,   //
      -sp, cp * sr, cp * cr;
  EXPECT_TRUE(rotation_from_roll_pitch_yaw(rpy).toRotationMatrix().isApprox(R, 1e-14));
}

// A dome as steep as the wrap bears: parts of the wrapped strokes are too steep, others lost. Each
// length counts as it is on the page, and what is left out is shown where it would lie.
TEST(Stages, WhatAWrapPromisesAndLeavesOutAddsUpToThePage) {
  const PreparedPlan e = prepare_plan(
      scenario({"drawing.mapping=wrap", "drawing.shape=sine", "drawing.placement.scale=1.4",
                "canvas.kind=dome", "canvas.cap.radius=0.15", "canvas.cap.centre=[0.6, 0, 0.02]",
                "canvas.cap.opening_radius=0.1499", "preflight.arm=false"}),
      {}, Unreachable::tell);
  const Promise promise = yardstick_of(e, e.truth).promise;
  ASSERT_GT(e.plan.laid->size(), 1u);
  ASSERT_GT(promise.lengths.at("too_steep"), 0.01);
  ASSERT_GT(promise.lengths.at("off_canvas"), 0.01);
  EXPECT_LE(promise.unnamed, 1e-3);
  EXPECT_NEAR(promise.promised + promise.undrawable + promise.unnamed, promise.asked, 1e-3);
  EXPECT_NEAR(promise.flat * plane_length(e.plan.strokes), promise.promised, 1e-9);
  const std::vector<PlanLine> lines = lines_of_findings(e, e.surface());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Finding& f = e.plan.preflight.findings[i];
    double nearest = 1.0;
    for (const Eigen::Vector3d& p_P : lines[i].points)
      nearest = std::min(nearest, (e.artwork.X_WP * p_P - f.p_W).norm());
    EXPECT_LT(nearest, 3e-3) << finding_text(f);
  }
}

// By dense algebra: what each joint's friction is at the tip, along the push.
TEST(Stages, FrictionThatNoWrenchShowsIsTold) {
  const auto told = [](const std::vector<std::string>& more) -> std::string {
    DrawOptions options;
    options.scenario = "scenarios/bowl-sine-natural.yaml";
    options.assignments = more;
    const PreparedPlan e = prepare_plan(resolve(options));
    ArmModel arm = e.belief.arm;
    ArmTerms terms(arm.joints());
    arm.compute(e.plan.rest_q, JointVector::Zero(arm.joints()), &terms);
    const Eigen::MatrixXd J = terms.J, M_inverse = Eigen::MatrixXd(terms.M).inverse();
    const Eigen::MatrixXd to_tip = (J * M_inverse * J.transpose()).inverse() * J * M_inverse;
    const double most = e.truth.world->dry_friction().dot(to_tip.row(2).cwiseAbs());
    for (const std::string& note : e.plan.notes)
      if (note.find("dry friction") != std::string::npos)
        return note.find(fmt::format("up to {:.2g} N at the tip", most)) != std::string::npos
                   ? "with its force"
                   : note;
    return "nothing";
  };
  EXPECT_EQ(told({"world.joint_friction=1"}), "with its force");
  EXPECT_EQ(told({"world.joint_friction=0.05"}), "nothing");
  EXPECT_EQ(told({"world.joint_friction=1", "control.wrench=ground_truth"}), "nothing");
}

}  // namespace
}  // namespace impedraw

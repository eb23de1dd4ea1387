// Placement of drawings: a canvas moved within the arm's reach, and a page wrapped round a surface.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <regex>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "drawn_scenario.h"
#include "impedraw/common/errors.h"
#include "impedraw/experiment/place_auto.h"

namespace impedraw {
namespace {

// The standard bowl with its cameras, 0.3 m too far away and 0.3 m to the side.
Scenario out_of_reach() {
  DrawOptions options;
  options.assignments = {"drawing.redraw=false"};
  return moved(resolve(options), {0.3, 0.3}, 20.0);
}

TEST(Placing, AMovedSceneIsTheSameScene) {
  DrawOptions options;
  const Scenario scenario = resolve(options);
  const Prepared here = prepare(scenario), there = prepare(moved(scenario, {0.02, -0.05}, 30.0));
  ASSERT_EQ(here.yardstick.target.points.size(), there.yardstick.target.points.size());
  const Eigen::Vector3d pivot(0.6, 0.0, 0.0), shift(0.02, -0.05, 0.0);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(std::numbers::pi / 6, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (std::size_t i = 0; i < here.yardstick.target.points.size(); i += 10)
    ASSERT_LT((R * (here.yardstick.target.points[i] - pivot) + pivot + shift -
               there.yardstick.target.points[i])
                  .norm(),
              1e-4)
        << i;
  EXPECT_NEAR(here.plan.path.pen_down_length(), there.plan.path.pen_down_length(), 1e-4);
}

TEST(Placing, ARecordedMotionIsRefused) {
  Scenario scenario = resolve(DrawOptions());
  scenario.canvas.motion.file = "somewhere.csv";
  try {
    place_automatically(scenario, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "--place auto cannot move a recorded motion: canvas.motion.file must be empty");
  }
}

// What was seen stands where it is: each place was tried in vain, and the message told nothing.
TEST(Placing, WhatWasSeenIsNotMoved) {
  Scenario scenario = resolve(DrawOptions());
  scenario.canvas.kind = CanvasKind::seen;
  try {
    place_automatically(scenario, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "--place auto moves the canvas, and one of kind seen stands where it was seen; "
                 "valid is --place surface, which looks for a place on it");
  }
}

// Out of reach, the drawing is refused. After placing, all of it can be drawn, and no pose of an
// independent grid is much better.
TEST(Placing, FindsWhereTheArmReachesBest) {
  const Scenario far = out_of_reach();
  const Prepared refused = prepare(far, {}, Unreachable::tell);
  ASSERT_FALSE(refused.plan.preflight.findings.empty());
  const PlacedCanvas found = place_automatically(far, {});
  EXPECT_TRUE(found.passes);
  EXPECT_LT(found.margin_before, 0.0);
  EXPECT_GT(found.margin, 0.25);
  const Prepared there = prepare(found.scenario);
  EXPECT_TRUE(there.plan.preflight.findings.empty());
  DrawOptions standard;
  EXPECT_GE(there.plan.preflight.margins.joint,
            0.8 * prepare(resolve(standard)).plan.preflight.margins.joint);
  EXPECT_GT(found.margin, place_automatically(resolve(standard), {}).margin - 0.05)
      << "wherever it stood before";
}

// The iiwa as if it were two and a half times as large: it cannot fold up to the usual canvas.
TEST(Placing, ALargeArmDrawsFartherAway) {
  std::stringstream text;
  text << std::ifstream("models/iiwa14_pen.urdf").rdbuf();
  const std::string given = text.str();
  const std::regex lengths("(xyz|radius|length|effort)=\"([^\"]*)\"");
  std::string urdf;
  auto end = given.cbegin();
  for (std::sregex_iterator it(given.begin(), given.end(), lengths), none; it != none; ++it) {
    urdf.append(end, (*it)[0].first);
    urdf += (*it)[1].str() + "=\"";
    std::stringstream numbers((*it)[2].str());
    const char* before = "";
    for (double x = 0.0; numbers >> x; before = " ") urdf += before + std::to_string(2.5 * x);
    urdf += "\"";
    end = (*it)[0].second;
  }
  urdf.append(end, given.cend());
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("large_arm_" + std::to_string(getpid()) + ".urdf");
  std::ofstream(file) << urdf;
  DrawOptions options;
  options.assignments = {"arm.urdf=" + file.string()};
  const PlacedCanvas found = place_automatically(resolve(options), {});
  std::filesystem::remove(file);
  EXPECT_TRUE(found.passes);
  EXPECT_GT(found.scenario.drawing.placement.centre_m.norm(), 0.75);
  EXPECT_GT(found.scenario.arm.start_p_WE.x(), 0.6);
}

// A sheet round a cylinder keeps its lengths. A projection stretches lengths across it by up to
// 1 / cos(slope).
TEST(Placing, WrappedLengthsAreThePages) {
  const std::vector<std::string> across = {
      "canvas.kind=cylinder",        "canvas.cylinder.middle=[0.6, 0, 0.2]",
      "canvas.cylinder.radius=0.15", "canvas.cylinder.width=0.26",
      "canvas.cylinder.length=0.36", "drawing.shape=circle",
      "drawing.placement.scale=1.5"};
  std::vector<std::string> wrapped = across;
  wrapped.push_back("drawing.mapping=wrap");
  const double page = 2 * std::numbers::pi * 0.09;
  DrawOptions options;
  options.scenario = "scenarios/bowl.yaml";
  options.assignments = across;
  EXPECT_GT(prepare(resolve(options)).plan.path.pen_down_length(), 1.02 * page);
  options.assignments = wrapped;
  const Prepared e = prepare(resolve(options));
  EXPECT_NEAR(e.plan.path.pen_down_length(), page, 1e-3 * page);
  const Figures f = draw_scenario("bowl", wrapped);
  EXPECT_EQ(f["coverage"], 1.0);
  EXPECT_LE(f["ink_error_rms"], 0.05);
}

}  // namespace
}  // namespace impedraw

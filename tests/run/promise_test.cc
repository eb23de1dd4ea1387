// What the pre-flight promises, and what the log keeps of it.
#include "impedraw/experiment/truth.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <gmock/gmock.h>

#include "impedraw/common/errors.h"
#include "impedraw/experiment/prepare.h"
#include "impedraw/run/simulated_arm.h"

namespace impedraw {
namespace {

Promise promise(const PreparedPlan& e) { return yardstick_of(e, e.truth).promise; }

constexpr double kRounding = 1e-4;  // [m]

// Leaves on a plane that leans: part of them is out of reach.
PreparedPlan partly_drawable() {
  DrawOptions options;
  options.scenario = "scenarios/reach-leaning.yaml";
  options.svg = "artwork/leaf.svg";
  options.assignments = {"drawing.hatch.spacing=7", "drawing.hatch.angle=30"};
  return prepare_plan(resolve(options), {}, Unreachable::tell);
}

// A plan said that all could be drawn, and drawing was refused.
TEST(Promise, APlanRefusesTheRotorsThatDrawingRefuses) {
  DrawOptions options;
  options.scenario = "scenarios/bowl-sine.yaml";
  options.assignments = {"world.errors.rotor_inertia=0.3"};
  Places places;
  const Scenario scenario = resolve(options, &places);
  try {
    prepare_plan_visibly(scenario, places);
    FAIL() << "is planned";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("the true rotors differ from arm.rotor_inertia"));
  }
}

// Whatever is taken away from what is promised or named, its length is missed.
TEST(Promise, LengthThatIsNeitherPromisedNorNamedIsFound) {
  PreparedPlan drawing = partly_drawable();
  Preflight& preflight = drawing.plan.preflight;
  ASSERT_FALSE(preflight.findings.empty());
  ASSERT_FALSE(preflight.drawable.empty());
  EXPECT_LE(unnamed_length(drawing), kRounding);
  const auto shorter = [](const Finding& a, const Finding& b) {
    return a.part.length() < b.part.length();
  };
  const auto longest =
      std::max_element(preflight.findings.begin(), preflight.findings.end(), shorter);
  const double named_length = longest->part.length();
  ASSERT_GT(named_length, 5e-3);
  preflight.findings.erase(longest);
  EXPECT_NEAR(unnamed_length(drawing), named_length, kRounding);
  const double promised = preflight.drawable.back().length();
  preflight.drawable.pop_back();
  EXPECT_NEAR(unnamed_length(drawing), named_length + promised, 2 * kRounding);
}

TEST(Promise, LengthsAddUpAndComeBackFromTheLog) {
  const PreparedPlan drawing = partly_drawable();
  const Promise given = promise(drawing);
  EXPECT_NEAR(given.promised + given.undrawable + given.unnamed, given.asked, 2e-4);
  EXPECT_GT(given.undrawable, 5e-3);
  EXPECT_FALSE(given.problems.empty());
  EXPECT_EQ(given.time, drawing.plan.path.duration());
  const auto back = read_promise({{kPromiseAttribute, promise_text(given)}});
  ASSERT_TRUE(back);
  EXPECT_EQ(back->asked, given.asked);
  EXPECT_EQ(back->promised, given.promised);
  EXPECT_EQ(back->reachable, given.reachable);
  EXPECT_EQ(back->problems, given.problems);
  EXPECT_EQ(back->slope, given.slope);
  EXPECT_EQ(back->axis_W, given.axis_W);
  EXPECT_FALSE(read_promise({}));
  EXPECT_FALSE(read_promise({{kPromiseAttribute, "no JSON"}}));
}

// Closed forms: of a line through a dome, what leans by less than 75°; of a plane, all or nothing.
TEST(Promise, WhatAPerfectPlannerCouldReachIsWhatTheTrueCanvasHasBelow) {
  DrawOptions options;
  options.scenario = "scenarios/bowl-sine.yaml";
  options.svg = "artwork/hatch.svg";
  options.assignments = {"canvas.kind=dome",
                         "canvas.cap.radius=0.1",
                         "canvas.cap.centre=[0.6, 0, 0.05]",
                         "canvas.cap.opening_radius=0.0999",
                         "drawing.placement.width=180",
                         "preflight.arm=false"};
  const PreparedPlan dome = prepare_plan(resolve(options), {}, Unreachable::tell);
  const double within = 0.1 * std::sin(75.0 / 180.0 * std::numbers::pi);
  double expected = 0.0;
  for (const PlacedStroke& stroke : dome.artwork.strokes)
    for (std::size_t i = 0; i + 1 < stroke.p_P.size(); ++i)
      for (double s = 0.5e-4; s < 1.0; s += 1e-4) {
        const Eigen::Vector2d piece = stroke.p_P[i + 1] - stroke.p_P[i];
        const Eigen::Vector2d p = stroke.p_P[i] + s * piece - Eigen::Vector2d(0.6, 0.0);
        expected += p.norm() < within ? 1e-4 * piece.norm() : 0.0;
      }
  ASSERT_LT(expected, 0.99 * promise(dome).asked);
  EXPECT_NEAR(reachable_length(dome, dome.truth), expected, 5e-3 * expected);

  options.scenario = "scenarios/robustness-nominal.yaml";
  options.svg.clear();
  for (const auto& [cosine, share] : {std::pair(0.30, 1.0), std::pair(0.20, 0.0)}) {
    const double sine = std::sqrt(1.0 - cosine * cosine);
    options.assignments = {
        "preflight.arm=false",
        "canvas.plane.normal=[0, " + std::to_string(sine) + ", " + std::to_string(cosine) + "]"};
    const PreparedPlan plane = prepare_plan(resolve(options), {}, Unreachable::tell);
    EXPECT_NEAR(reachable_length(plane, plane.truth), share * promise(plane).asked, 1e-9);
  }
}

// A plane of known slope.
TEST(Promise, SlopeIsThatOfThePlane) {
  DrawOptions options;
  options.scenario = "scenarios/robustness-nominal.yaml";
  options.assignments = {"canvas.plane.normal=[0, 0.5, 0.866025404]"};
  EXPECT_NEAR(promise(prepare_plan(resolve(options))).slope * 180.0 / std::numbers::pi, 30.0, 1e-6);
}

}  // namespace
}  // namespace impedraw

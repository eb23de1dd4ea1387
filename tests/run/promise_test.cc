// What the pre-flight promises, and what the log keeps of it.
#include "impedraw/run/promise_of.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "impedraw/experiment/draw_options.h"

namespace impedraw {
namespace {

constexpr double kRounding = 1e-4;  // [m]

// Leaves on a plane that leans: part of them is out of reach.
PlannedDrawing partly_drawable() {
  DrawOptions options;
  options.scenario = "scenarios/reach-leaning.yaml";
  options.svg = "artwork/leaf.svg";
  options.assignments = {"drawing.hatch.spacing=7", "drawing.hatch.angle=30"};
  return prepare_plan(resolve(options), {}, Unreachable::tell);
}

// Whatever is taken away from what is promised or named, its length is missed.
TEST(Promise, LengthThatIsNeitherPromisedNorNamedIsFound) {
  PlannedDrawing drawing = partly_drawable();
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
  const PlannedDrawing drawing = partly_drawable();
  const Promise promise = promise_of(drawing);
  EXPECT_NEAR(promise.promised + promise.undrawable + promise.unnamed, promise.asked, 2e-4);
  EXPECT_GT(promise.undrawable, 5e-3);
  EXPECT_FALSE(promise.problems.empty());
  EXPECT_EQ(promise.time, drawing.plan.path.duration());
  const auto back = read_promise({{kPromiseAttribute, promise_text(promise)}});
  ASSERT_TRUE(back);
  EXPECT_EQ(back->asked, promise.asked);
  EXPECT_EQ(back->promised, promise.promised);
  EXPECT_EQ(back->problems, promise.problems);
  EXPECT_EQ(back->slope, promise.slope);
  EXPECT_EQ(back->axis_W, promise.axis_W);
  EXPECT_FALSE(read_promise({}));
  EXPECT_FALSE(read_promise({{kPromiseAttribute, "no JSON"}}));
}

// A plane of known slope.
TEST(Promise, SlopeIsThatOfThePlane) {
  DrawOptions options;
  options.scenario = "scenarios/robustness-nominal.yaml";
  options.assignments = {"canvas.plane.normal=[0, 0.5, 0.866025404]"};
  const Promise promise = promise_of(prepare_plan(resolve(options)));
  EXPECT_NEAR(promise.slope * 180.0 / std::numbers::pi, 30.0, 1e-6);
}

}  // namespace
}  // namespace impedraw

// The force along a stroke: what was asked for, smooth, and no steeper than allowed.
#include "impedraw/planning/path/force_profile.h"

#include <cmath>

#include <gtest/gtest.h>

#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/stroke_part.h"
#include "planning/surfaces.h"

namespace impedraw {
namespace {

PlacedStroke pressed(const std::vector<double>& x, std::vector<double> force) {
  PlacedStroke stroke;
  for (const double at : x) {
    stroke.p_P.emplace_back(at, 0.0);
    stroke.page.emplace_back(1e3 * at, 0.0);
  }
  stroke.force = std::move(force);
  return stroke;
}

TEST(ForceProfile, FollowsAWedgeAndItsSlopeIsTheDerivative) {
  const ForceProfile force(pressed({0.0, 0.01, 0.02}, {1.0, 8.0, 1.0}), 2e3);
  for (double s = -0.001; s <= 0.021; s += 1.7e-4) {
    const double wedge = s < 0.0 || s > 0.02 ? 1.0 : 8.0 - std::abs(s - 0.01) * 700.0;
    // Beside a kink by a sixth of the slope's change over a step.
    EXPECT_NEAR(force.at(s).force, wedge, 1400.0 * ForceProfile::kStep / 6.0 + 1e-12) << s;
    const double h = 1e-6;
    EXPECT_NEAR(force.at(s).slope, (force.at(s + h).force - force.at(s - h).force) / (2.0 * h),
                s < h || s > 0.02 - h ? 400.0 : 1.5)
        << s;
  }
  EXPECT_EQ(force.spread_length(1e-9), 0.0);
  EXPECT_TRUE(ForceProfile(pressed({0.0, 0.01}, {}), 1.0).empty());
  EXPECT_EQ(ForceProfile(pressed({0.3}, {4.0}), 1.0).at(7.0).force, 4.0);  // a dot
  EXPECT_EQ(ForceProfile(pressed({0.0, 0.1}, {3.0, 3.0}), 1.0).at(0.05).slope, 0.0);
}

TEST(ForceProfile, SpreadsAJumpToTheHeavierSide) {
  const double steepest = 2e3;
  const ForceProfile force(pressed({0.0, 0.02, 0.02, 0.05}, {2.0, 2.0, 6.0, 6.0}), steepest);
  for (double s = 0.0; s <= 0.05; s += 1e-4) {
    EXPECT_LE(std::abs(force.at(s).slope), steepest * (1.0 + 1e-9));
    const double limited = std::min(6.0, 2.0 + steepest * std::max(0.0, s - 0.02));
    EXPECT_NEAR(force.at(s).force, limited, steepest * ForceProfile::kStep);
  }
  EXPECT_NEAR(force.spread_length(0.2), 4.0 / steepest, 2.0 * ForceProfile::kStep);
}

// The path's force is the profile's where the pen is, and its rate the derivative by time; a part
// of a stroke has the forces of that part.
TEST(ForceProfile, AlongThePath) {
  const PlacedStroke whole = pressed({0.56, 0.6, 0.64}, {1.0, 8.0, 2.0});
  const PlacedStroke part = part_of(whole, 0.01, 0.07);
  EXPECT_NEAR(part.force.front(), 2.75, 1e-12);
  EXPECT_NEAR(part.force.back(), 3.5, 1e-12);
  const TipPath path = plan_tip_path({part}, surfaces::bowl);
  const StrokeTimes times = path.strokes()[0];
  const ForceProfile force(part, 2e3);
  for (double t = 0.0; t < path.duration(); t += 0.01) {
    const PathSample at = path.at(t);
    if (!at.reference.pen_down) {
      EXPECT_EQ(at.reference.force, 0.0);
      continue;
    }
    const double along = t < times.start ? 0.01 : t >= times.end ? 0.07 : at.along;
    EXPECT_NEAR(at.reference.force, force.at(along).force, 1e-9) << t;
    const double h = 1e-5;
    if (std::abs(t - times.start) < h || std::abs(t - times.end) < h) continue;
    EXPECT_NEAR(at.reference.force_rate,
                (path.at(t + h).reference.force - path.at(t - h).reference.force) / (2.0 * h), 0.3)
        << t;
  }
}

// Half the speed, and 0.5 s of rest before the second stroke, where a person is asked.
TEST(ForceProfile, StrokesHaveTheirOwnSpeedAndWaits) {
  PlacedStroke first = pressed({0.56, 0.6}, {}), second = pressed({0.6, 0.64}, {});
  const TipPath plain = plan_tip_path({first, second}, surfaces::bowl);
  second.speed = PathSettings().draw_speed / 2.0;
  second.wait = 0.5;
  second.pause = true;
  const TipPath path = plan_tip_path({first, second}, surfaces::bowl);
  EXPECT_TRUE(plain.pauses().empty());
  ASSERT_EQ(path.pauses().size(), 1u);
  EXPECT_NEAR(path.strokes()[1].approach - plain.strokes()[1].approach, 0.5, 1e-9);
  for (double t = path.pauses()[0]; t < path.pauses()[0] + 0.5; t += 0.1) {
    EXPECT_EQ(path.at(t).reference.v_WD.norm(), 0.0);
    EXPECT_FALSE(path.at(t).reference.pen_down);
  }
  const StrokeTimes slow = path.strokes()[1];
  const double middle = (slow.start + slow.end) / 2.0;
  EXPECT_NEAR(path.at(middle).reference.v_WD.norm(), second.speed, 2e-3 * second.speed);
}

}  // namespace
}  // namespace impedraw

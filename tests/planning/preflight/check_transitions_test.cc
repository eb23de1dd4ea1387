// The ways between the strokes of planned paths.
#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "arm_on_surface.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/preflight/preflight.h"
#include "planning/surfaces.h"

namespace impedraw {
namespace {

std::vector<Finding> ways(ArmModel& arm, const std::vector<PlacedStroke>& strokes,
                          const SurfaceHeight& surface, const Canvas* obstacle) {
  PathSettings path;
  path.start_p_WE = {0.5, 0, 0.3};
  return check_transitions(plan_tip_path(strokes, surface, path), strokes, arm, obstacle,
                           surfaces::start_posture(arm));
}

TEST(PreflightWays, AreFreeOverAnEmptyTable) {
  ArmModel arm(surfaces::kArm);
  const auto findings = ways(arm, surfaces::shape("M"), surfaces::bowl, nullptr);
  EXPECT_TRUE(findings.empty()) << findings.front().text;
}

TEST(PreflightWays, AWallOnTheWayIsSaidOfTheStrokeBehindIt) {
  ArmModel arm(surfaces::kArm);
  auto first = surfaces::line({{0.60, 0.02}, {0.60, 0.06}}),
       second = surfaces::line({{0.60, -0.06}, {0.60, -0.10}});
  first.number = 4;
  second.number = 7;
  // Across y = −0.02, too high for the safe height of 30 mm and too low for the flange.
  const TriangleMesh mesh{
      {{0.4, -0.02, 0}, {0.8, -0.02, 0}, {0.8, -0.02, 0.16}, {0.4, -0.02, 0.16}},
      {{0, 1, 2}, {0, 2, 3}}};
  const Canvas wall(mesh);
  EXPECT_TRUE(
      check_strokes({first, second}, surfaces::flat(0.1), arm, &wall, surfaces::start_posture(arm))
          .findings.empty());
  const auto findings = ways(arm, {first, second}, surfaces::flat(0.1), &wall);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].part.stroke, 7);
  EXPECT_NEAR(findings[0].part.length(), 0.04, 1e-12);
  EXPECT_EQ(findings[0].problem, Problem::pen_collision);
  EXPECT_EQ(findings[0].text.find("on the way there: the tool"), 0u) << findings[0].text;
  EXPECT_NEAR(findings[0].p_W.y(), -0.02, 0.011);
}

TEST(PreflightWays, AWayOutOfReachIsSaid) {
  ArmModel arm(surfaces::kArm);
  // Both ends are within reach; straight up to 0.75 m and the upright pen is not.
  const auto stroke = surfaces::line({{0.72, 0}, {0.74, 0}});
  PathSettings path;
  path.start_p_WE = {0.5, 0, 0.3};
  path.highest_z = 0.75;
  const auto findings = check_transitions(plan_tip_path({stroke}, surfaces::flat(0.1), path),
                                          {stroke}, arm, nullptr, surfaces::start_posture(arm));
  std::set<Problem> seen;
  for (const Finding& finding : findings) seen.insert(finding.problem);
  EXPECT_TRUE(seen.count(Problem::out_of_reach));
}

// The stroke runs out of the arm's reach, and nobody asked check_strokes.
TEST(PreflightWays, AStrokeThatTheArmCannotFollowIsSaidWithItsPart) {
  ArmModel arm(surfaces::kArm);
  const auto stroke = surfaces::line({{0.70, 0}, {1.00, 0}});
  const auto findings = ways(arm, {stroke}, surfaces::flat(0.1), nullptr);
  const auto lost = std::find_if(findings.begin(), findings.end(),
                                 [](const Finding& f) { return f.way == WayEnd::none; });
  ASSERT_NE(lost, findings.end());
  EXPECT_TRUE(lost->problem == Problem::out_of_reach || lost->problem == Problem::joint_limit ||
              lost->problem == Problem::near_singular)
      << name_of(lost->problem);
  EXPECT_GT(lost->part.from, 0.02);
  EXPECT_NEAR(lost->part.to, 0.30, 0.012);
  EXPECT_EQ(lost->text.find("from the way there: "), 0u) << lost->text;
  // Where the first pass drew its line, the second finds nothing.
  const Preflight first =
      check_strokes({stroke}, surfaces::flat(0.1), arm, nullptr, surfaces::start_posture(arm));
  ASSERT_EQ(first.drawable.size(), 1u);
  const PlacedStroke rest = part_of(stroke, 0.0, first.drawable[0].to);
  for (const Finding& f : ways(arm, {rest}, surfaces::flat(0.1), nullptr))
    EXPECT_NE(f.way, WayEnd::none) << f.text;
}

TEST(PreflightWays, ALiftOutOfReachIsSaidOfTheStrokeThatItIsOffAndOfNoOther) {
  ArmModel arm(surfaces::kArm);
  // Both on a table within reach; at 0.6 m and upright the arm gets to where the second is, but not
  // to where the first is.
  const auto far = surfaces::line({{0.72, 0}, {0.74, 0}}, 0),
             near = surfaces::line({{0.5, 0.02}, {0.5, -0.02}}, 1);
  PathSettings path;
  path.start_p_WE = {0.5, 0, 0.3};
  path.highest_z = 0.57;
  const auto asked = [&](const std::vector<PlacedStroke>& strokes) {
    return check_transitions(plan_tip_path(strokes, surfaces::flat(0.1), path), strokes, arm,
                             nullptr, surfaces::start_posture(arm));
  };
  EXPECT_TRUE(asked({near}).empty());
  const auto findings = asked({far, near});
  ASSERT_FALSE(findings.empty());
  bool lift = false;
  for (const Finding& f : findings) {
    EXPECT_EQ(f.part.stroke, 0) << f.text;
    lift |= f.text.starts_with("on the way off it: ");
  }
  EXPECT_TRUE(lift);
}

}  // namespace
}  // namespace impedraw

// Ground that nobody made for drawing: steep flanks and fine roughness.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "drawn_scenario.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

class RoughGround : public ScratchFolder {};

// A table 40 mm wide whose long sides are rounded off, by 8 mm, into walls of 85°.
std::string flanked_table() {
  constexpr double kRadius = 0.008, kFlat = 0.02, kWall = 85.0 * std::numbers::pi / 180.0;
  std::vector<Eigen::Vector2d> half;
  for (int i = 0; i < 40; ++i) {
    const double a = kWall * i / 39.0;
    half.emplace_back(kFlat + kRadius * std::sin(a), kRadius * (std::cos(a) - 1.0));
  }
  half.emplace_back(half.back() + 0.04 * Eigen::Vector2d(std::cos(kWall), -std::sin(kWall)));
  std::vector<Eigen::Vector2d> profile;
  for (auto p = half.rbegin(); p != half.rend(); ++p) profile.emplace_back(-p->x(), p->y());
  profile.insert(profile.end(), half.begin(), half.end());
  std::string text;
  for (const Eigen::Vector2d& p : profile)
    text += fmt::format("v -0.1 {0} {1}\nv 0.1 {0} {1}\n", p.x(), p.y());
  for (std::size_t i = 0; i + 1 < profile.size(); ++i)
    text += fmt::format("f {} {} {} {}\n", 2 * i + 1, 2 * i + 2, 2 * i + 4, 2 * i + 3);
  return text;
}

// Parts of 84° were promised, as the plan's smoothed normals lean less, and the pen slipped down
// them.
TEST_F(RoughGround, StrokesEndBeforeASteepFlank) {
  DrawOptions options;
  options.scenario = "scenarios/surfaces.yaml";
  options.svg = write("cross.svg",
                      "<svg xmlns='http://www.w3.org/2000/svg' width='80mm' height='70mm' "
                      "viewBox='0 0 80 70'><path d='M5 5L75 65M5 65L75 5M0 35H80' fill='none' "
                      "stroke='black'/></svg>");
  options.assignments = {"canvas.kind=mesh",
                         "canvas.mesh.file=" + write("table.obj", flanked_table()).string(),
                         "drawing.placement.width=80"};
  const Figures f = draw_scenario(resolve(options));
  EXPECT_LT(f["slope_max"], 75.0);
  EXPECT_LT(f["ink_error_max"], 0.3);
  EXPECT_GT(f["coverage"], 0.99);
  EXPECT_GT(f["length_promised"], 150.0);
}

// "He", 60 mm wide, on fractal terrain.
Figures drawn_on_terrain(const std::string& slope_deg, const std::string& wavelength,
                         const std::vector<std::string>& more) {
  DrawOptions options;
  options.scenario = "scenarios/surfaces.yaml";
  options.text = "He";
  options.assignments = {"canvas.rough.slope=" + slope_deg, "canvas.rough.wavelength=" + wavelength,
                         "drawing.placement.width=60"};
  options.assignments.insert(options.assignments.end(), more.begin(), more.end());
  return draw_scenario(resolve(options));
}

// Waves of 4 mm on slopes of 20°, which no camera resolves.
TEST(LighterPen, PressesMoreSteadilyOnRoughGround) {
  const auto force_sd = [](const std::string& mass) {
    return drawn_on_terrain("20", "0.004", {"control.mass_normal=" + mass})["force_sd"];
  };
  EXPECT_LT(force_sd("null"), 0.7 * force_sd("3"));
}

// The tip of 1 mm touches waves of 2 mm with its side, up to 40° off the normal that the cameras
// see. Without a share of the felt normal the force tells nothing.
TEST(FeltNormal, KeepsForceAndInkWhereTheCamerasSmoothTheGround) {
  const Figures without = drawn_on_terrain("40", "0.002", {"control.felt_normal.share=0"}),
                with = drawn_on_terrain("40", "0.002", {});
  EXPECT_LT(with["force_sd"], 0.8 * without["force_sd"]);
  EXPECT_LT(with["ink_error_rms"], without["ink_error_rms"]);
  EXPECT_GE(with["coverage"], without["coverage"]);
}

// What is planned anew during a run starts elsewhere, and may miss the surface at an edge. The run
// ended there with an error, the pen in the air and no numbers written.
void expect_drawn_to_the_bowls_edge(Prepared e) {
  PlacedStroke& stroke = e.plan.strokes.front();
  stroke.p_P = {{0.60, 0.0}, {0.70, 0.0}, {0.80, 0.0}};  // the bowl ends at 0.78
  stroke.page = {{0.0, 0.0}, {100.0, 0.0}, {200.0, 0.0}};
  Resumption left;
  left.q = e.belief.start_q;
  const RunOutcome outcome = run(e, {}, 0.0, {}, &left);
  EXPECT_EQ(outcome.end, RunEnd::finished) << outcome.cause;
  ASSERT_EQ(outcome.lacking.size(), 1u);
  EXPECT_GT(outcome.lacking[0].from, 0.16);
  EXPECT_LT(outcome.lacking[0].from, 0.18);
  EXPECT_NEAR(outcome.lacking[0].to, 0.2, 1e-9);
}
TEST(PlannedAnew, WhatMissesTheSurfaceIsLeftOut) {
  expect_drawn_to_the_bowls_edge(prepare(resolve_scenario("bowl", {"drawing.shape=circle"})));
}
TEST(PlannedAnew, WhatMissesTheSurfaceIsLeftOutOnAWatchedCanvas) {
  for (const char* arm : {"true", "false"})
    expect_drawn_to_the_bowls_edge(prepare(resolve_scenario(
        "standing-noisy", {"drawing.shape=circle", std::string("preflight.arm=") + arm})));
}

}  // namespace
}  // namespace impedraw

// A blade from the scenario to its figures: yaw and corners, by the truth, and inputs that do not
// fit.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "drawn_scenario.h"
#include "impedraw/common/errors.h"
#include "impedraw/experiment/tool_fit.h"
#include "impedraw/experiment/truth.h"
#include "impedraw/log/run_rows.h"
#include "impedraw/planning/stroke_ruler.h"
#include "impedraw/run/tool_judge.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

struct Led {
  double yaw_rms, yaw_max, smear;
  std::vector<double> yaw_of_rows;
};

nlohmann::ordered_json cut(const std::string& scenario, std::vector<std::string> set = {}) {
  Prepared experiment = prepare(resolve_scenario(scenario, set));
  const std::unique_ptr<ToolJudge> judge = tool_judge(experiment);
  RunHooks hooks;
  hooks.row = [&](const LogRow& row) { judge->add(row); };
  const std::filesystem::path log = std::filesystem::temp_directory_path() /
                                    ("impedraw_blade_" + std::to_string(getpid()) + ".h5");
  const RunOutcome outcome = run(experiment, log, 0.0, hooks);
  EXPECT_EQ(outcome.end, RunEnd::finished) << outcome.cause;
  std::filesystem::remove(log);
  return judge->results()["metrics"];
}

std::string refusal(const std::string& scenario, const std::vector<std::string>& set) {
  try {
    prepare(resolve_scenario(scenario, set));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Blade, FollowsTheSine) {
  const auto figures = cut("bowl-blade", {"seed=3"});
  EXPECT_LE(figures["yaw_error_rms"].get<double>(), 2.0);
  EXPECT_GT(figures["yaw_error_rms"].get<double>(), 0.0);
}

TEST(Blade, SwivelsAtTheCornersOfAStar) {
  for (const char* swivel : {"spot", "lifted"}) {
    const auto figures = cut("bowl-blade-star", {"seed=3", std::string("tool.swivel=") + swivel});
    EXPECT_LE(figures["yaw_error_rms"].get<double>(), 2.0) << swivel;
    EXPECT_LE(figures["corner_smear"].get<double>(), 0.2) << swivel;
  }
}

// The judge is no part of what it judges: a heading that is off by 5° is found to be.
TEST(Blade, TheJudgeSeesAYawThatIsOff) {
  Scenario scenario = resolve_scenario("bowl-blade", {"seed=3", "tool.yaw=5"});
  Prepared experiment = prepare(scenario);
  experiment.scenario.tool.yaw_deg = 0.0;
  const std::unique_ptr<ToolJudge> judge = tool_judge(experiment);
  RunHooks hooks;
  hooks.row = [&](const LogRow& row) { judge->add(row); };
  const std::filesystem::path log = std::filesystem::temp_directory_path() /
                                    ("impedraw_blade_" + std::to_string(getpid()) + ".h5");
  run(experiment, log, 0.0, hooks);
  std::filesystem::remove(log);
  EXPECT_NEAR(judge->results()["metrics"]["yaw_error_rms"].get<double>(), 5.0, 0.5);
}

TEST(Blade, NamesWhatDoesNotFit) {
  EXPECT_THAT(refusal("bowl-blade", {"tool.radius=0.02"}), HasSubstr("tool.radius"));
  EXPECT_THAT(refusal("bowl-blade",
                      {"drawing.text.text=ab", "drawing.placement.height=4", "tool.radius=0.004"}),
              HasSubstr("tool.radius"));
  EXPECT_THAT(refusal("bowl-sine-blind", {"tool.kind=blade"}), HasSubstr("tool.kind"));
  EXPECT_THAT(refusal("bowl-blade-star", {"tool.radius=0.002", "tool.trail=0"}),
              HasSubstr("mm beside the corner of stroke 0"));
}

// What the arm cannot reach after that, where its base has turned on, is left out by name.
TEST(Blade, IsLiftedWhereTheArmCannotTurnOn) {
  const Prepared circle = prepare(
      resolve_scenario("bowl-blade", {"drawing.shape=circle", "drawing.skip_unreachable=true"}));
  EXPECT_THAT(circle.plan.notes, ::testing::Contains(HasSubstr("yaw: the arm turns the tool by")));
  EXPECT_GE(circle.plan.strokes.size(), 2u);
  EXPECT_GT(plane_length(circle.plan.strokes), 0.95 * plane_length(circle.artwork.strokes));
  // Parts of a stroke keep their place on it.
  EXPECT_LT(unnamed_length(circle), 1e-6);
}

// An arc that turns by less than the arm, but through headings to which the arm does not turn, is
// cut there, and drawn whole. One that ends at these is not cut.
TEST(Blade, IsLiftedWhereAnArcLeadsThroughTheEndOfTheArmsRange) {
  const std::filesystem::path svg = std::filesystem::temp_directory_path() /
                                    ("impedraw_arc_" + std::to_string(getpid()) + ".svg");
  std::ofstream(svg) << R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">)"
                     << R"(<path fill="none" stroke="black" d="M20,80A60,60 0 0 1 80,20"/></svg>)";
  for (const auto& [turned, cut] : {std::pair("60", true), std::pair("100", false)}) {
    SCOPED_TRACE(turned);
    const Prepared arc = prepare(resolve_scenario(
        "bowl-blade",
        {"drawing.svg=" + svg.string(), "drawing.placement.fit_radius=0.06",
         "drawing.placement.rotate=" + std::string(turned), "drawing.skip_unreachable=true"}));
    EXPECT_EQ(arc.plan.strokes.size() > 1, cut);
    EXPECT_NEAR(plane_length(arc.plan.strokes), plane_length(arc.artwork.strokes), 1e-6);
  }
  std::filesystem::remove(svg);
}

// Letters have arcs that lead a little beyond the range, and bends in which the tool turns slowly.
TEST(Blade, CutsText) {
  const Prepared text = prepare(
      resolve_scenario("bowl-blade", {"drawing.text.text=Cut 42", "drawing.placement.width=160"}));
  EXPECT_NEAR(plane_length(text.plan.strokes), plane_length(text.artwork.strokes), 1e-6);
}

// A spiral on an arm that turns the tool by 680°: each part has a turn, of those that lead to its
// first heading, after which all of it is within the range.
TEST(Blade, IsLiftedOnASpiralWhereNoTurnLeadsOn) {
  const double degree = std::numbers::pi / 180.0;
  PlacedStroke spiral;
  for (double t = 0.0; t < 1800.0; t += 2.0)
    spiral.p_P.push_back((0.02 + 2e-5 * t) *
                         Eigen::Vector2d(std::cos(t * degree), std::sin(t * degree)));
  spiral.page.resize(spiral.p_P.size());
  ToolHeading heading;
  heading.least = -300.0 * degree;
  heading.most = 380.0 * degree;
  std::vector<std::string> notes;
  const auto parts = cut_where_turned({spiral}, heading, 0.0, Pose(), 30.0 * degree, &notes);
  EXPECT_THAT(parts, ::testing::SizeIs(::testing::Le(5)));
  for (const PlacedStroke& part : parts) {
    std::vector<double> turned;
    for (std::size_t i = 1; i < part.p_P.size(); ++i) {
      const Eigen::Vector2d way = part.p_P[i] - part.p_P[i - 1];
      const double at = std::atan2(way.y(), way.x());
      turned.push_back(turned.empty() ? at
                                      : turned.back() + std::remainder(at - turned.back(),
                                                                       2.0 * std::numbers::pi));
    }
    const auto [low, high] = std::ranges::minmax(turned);
    bool fits = false;
    for (int k = -6; k <= 6; ++k)
      fits = fits || (low + 360.0 * k * degree >= heading.least - 2.1 * degree &&
                      high + 360.0 * k * degree <= heading.most + 2.1 * degree);
    EXPECT_TRUE(fits) << low / degree << " to " << high / degree << "°";
  }
}

// The parts of a stroke that is cut are judged by themselves, also where nothing is left out.
TEST(Blade, IsJudgedAlongTheStrokesThatWereCut) {
  DrawOptions options;
  options.scenario = "scenarios/bowl-blade.yaml";
  options.svg = "artwork/spiral.svg";
  options.assignments = {"drawing.placement.width=100", "drawing.skip_unreachable=true"};
  const Figures figures = draw_scenario(resolve(options));
  EXPECT_GT(figures["coverage"], 0.99);
  EXPECT_LT(figures["ink_error_max"], 0.2);
}

// The second part of a run knows where the first has found the surface, and counts what it cut.
TEST(Engraver, GoesOnInItsGroove) {
  const Scenario scenario = resolve_scenario("bowl-engrave-real", {"drawing.shape=circle"});
  const std::filesystem::path log = std::filesystem::temp_directory_path() /
                                    ("impedraw_engraver_" + std::to_string(getpid()) + ".h5");
  double now = 0.0;
  RunHooks hooks;
  hooks.progress = [&](const RunProgress& p) { now = p.time; };
  hooks.interrupted = [&] { return now > 30.0; };  // in the second pass
  Prepared first = prepare(scenario);
  ASSERT_EQ(run(first, log, 0.0, hooks).end, RunEnd::interrupted);

  Prepared second = prepare(scenario);
  const std::unique_ptr<ToolJudge> judge = tool_judge(second);
  int rows = 0;
  visit_rows(log, [&](const LogRow& row) {
    if (++rows % 15 == 0) judge->add(row);  // as a reduced log has them
  });
  const Resumption resumption = read_resumption(second, log).value();
  EXPECT_GT(resumption.scores.size(), 1000u);
  RunHooks judged;
  judged.row = [&](const LogRow& row) { judge->add(row); };
  run(second, log, 0.0, judged, &resumption);
  std::filesystem::remove(log);
  EXPECT_LT(judge->results()["metrics"]["depth_error_rms"].get<double>(), 0.03);
}

}  // namespace
}  // namespace impedraw

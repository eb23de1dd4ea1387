// A nozzle from the scenario to its figures: the jet keeps its distance and its speed, and touches
// nothing.
#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "drawn_scenario.h"
#include "impedraw/arm/arm_model.h"
#include "impedraw/common/errors.h"
#include "impedraw/experiment/input_files.h"
#include "impedraw/run/tool_judge.h"

namespace impedraw {
namespace {

struct Sprayed {
  nlohmann::ordered_json figures;
  double height = 0.0, height_error = 0.0;  // of arm.urdf's own tip over z = 0, while it is open
  double force = 0.0;                       // the greatest
};

Sprayed spray(const std::string& scenario, std::vector<std::string> set) {
  set.emplace_back("tool.kind=nozzle");
  Prepared e = prepare(resolve_scenario(scenario, set));
  ArmModel bare = model_of(e.scenario.arm);  // knows of no nozzle
  const std::unique_ptr<ToolJudge> judge = tool_judge(e);
  Sprayed s;
  std::vector<double> heights;
  RunHooks hooks;
  hooks.row = [&](const LogRow& row) {
    judge->add(row);
    s.force = std::max(s.force, row.contact_force.norm());
    if (row.stroke >= 0) heights.push_back(bare.tip_pose(row.joint_position).p.z());
  };
  const std::filesystem::path log = std::filesystem::temp_directory_path() /
                                    ("impedraw_nozzle_" + std::to_string(getpid()) + ".h5");
  const RunOutcome outcome = run(e, log, 0.0, hooks);
  EXPECT_EQ(outcome.end, RunEnd::finished) << outcome.cause;
  EXPECT_TRUE(outcome.lacking.empty());
  std::filesystem::remove(log);
  for (const double h : heights) s.height += h / static_cast<double>(heights.size());
  for (const double h : heights) s.height_error = std::max(s.height_error, std::abs(h - s.height));
  s.figures = judge->results()["metrics"];
  return s;
}

// By the arm's own tip, which no code of the nozzle's has moved.
TEST(Nozzle, StandsOffAPlane) {
  const double z = 0.12;
  for (const double stand_off : {0.02, 0.12}) {
    const Sprayed s = spray(
        "bowl-sine", {"canvas.kind=plane", fmt::format("canvas.plane.centre=[0.6,0,{}]", z),
                      "canvas.plane.normal=[0,0,1]", "canvas.plane.width=0.4",
                      "canvas.plane.height=0.4", fmt::format("tool.stand_off={}", stand_off)});
    EXPECT_NEAR(s.height, z + stand_off, 3e-4);
    EXPECT_LT(s.height_error, 5e-4);
    EXPECT_LT(s.figures["stand_off_error_max"], 0.5);
    EXPECT_EQ(s.figures["jet_missed_share"], 0.0);
    EXPECT_EQ(s.force, 0.0);
  }
}

// On a curved canvas the nozzle goes another way than the place that its jet meets, whose speed is
// what counts: 20 mm/s are asked for.
TEST(Nozzle, KeepsDistanceAndSpeedInABowl) {
  const Sprayed s = spray("bowl-sine-realistic", {"tool.stand_off=0.05", "path.draw_speed=0.02"});
  EXPECT_LT(s.figures["stand_off_error_rms"], 0.5);
  EXPECT_NEAR(s.figures["jet_speed_mean"], 20.0, 1.5);
  EXPECT_LT(s.figures["jet_speed_sd"], 4.0);
  EXPECT_EQ(s.force, 0.0);
}

TEST(Nozzle, NeedsASurfaceThatIsSeen) {
  try {
    spray("bowl-sine-touch", {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("tool.kind is nozzle"));
  }
}

}  // namespace
}  // namespace impedraw

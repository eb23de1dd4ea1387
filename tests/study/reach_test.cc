// ./impedraw reach: every combination is there, the judge counts right, and the ten quickest meet
// their limits.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/experiment/draw_options.h"
#include "impedraw/study/reach.h"
#include "impedraw/study/reach_cells.h"
#include "impedraw/study/reach_run.h"
#include "process.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

Cell named(const std::string& name) {
  for (const Cell& cell : reach_cells())
    if (cell.name == name) return cell;
  ADD_FAILURE() << name;
  return {};
}

Experiment prepared(const std::string& name) {
  return prepare(cell_scenario(named(name)), {}, Unreachable::tell);
}

TEST(ReachCells, EveryDrawingOnEveryCanvas) {
  std::set<std::string> names, drawings;
  std::map<std::string, CanvasKind> canvases;
  for (const Cell& cell : reach_cells()) {
    const Scenario s = cell_scenario(cell);
    EXPECT_TRUE(names.insert(cell.name).second) << cell.name;
    EXPECT_EQ(cell.name.find_first_of(" ,;\"'"), std::string::npos) << cell.name;
    EXPECT_TRUE(s.drawing.svg.empty() || std::filesystem::exists(s.drawing.svg)) << s.drawing.svg;
    EXPECT_NE(s.drawing.svg.empty(), s.drawing.text.text.empty()) << cell.name;
    drawings.insert(s.drawing.svg.string() + s.drawing.text.text);
    const auto [it, fresh] = canvases.emplace(cell.column, s.canvas.kind);
    EXPECT_EQ(it->second, s.canvas.kind) << cell.name;
  }
  EXPECT_EQ(names.size(), 100u);
  EXPECT_EQ(drawings.size(), 10u);
  EXPECT_EQ(canvases.size(), 10u);
  const auto meshes = std::count_if(canvases.begin(), canvases.end(),
                                    [](const auto& c) { return c.second == CanvasKind::mesh; });
  EXPECT_GE(meshes, 2);
}

// Whatever is taken away from what is promised or named, its length is missed.
TEST(ReachJudge, LengthThatIsNeitherPromisedNorNamedIsFound) {
  Experiment e = prepared("leaf-on-leaning");
  ASSERT_FALSE(e.plan.preflight.findings.empty());
  ASSERT_FALSE(e.plan.preflight.drawable.empty());
  EXPECT_LE(unnamed_mm(e), kMostUnnamed);
  const auto longest = std::max_element(
      e.plan.preflight.findings.begin(), e.plan.preflight.findings.end(),
      [](const Finding& a, const Finding& b) { return a.part.length() < b.part.length(); });
  const double named_length = 1e3 * longest->part.length();
  ASSERT_GT(named_length, 5.0);
  e.plan.preflight.findings.erase(longest);
  EXPECT_NEAR(unnamed_mm(e), named_length, kMostUnnamed);
  const double promised = 1e3 * e.plan.preflight.drawable.back().length();
  e.plan.preflight.drawable.pop_back();
  EXPECT_NEAR(unnamed_mm(e), named_length + promised, 2 * kMostUnnamed);
}

// On a sphere a point's slope is known: asin of its distance from the axis over the radius.
TEST(ReachJudge, InkErrorCountsWhereTheCanvasIsGentle) {
  DrawOptions options;
  options.assignments = {"canvas.kind=dome",
                         "canvas.cap.radius=0.15",
                         "canvas.cap.centre=[0.6, 0, 0]",
                         "canvas.cap.opening_radius=0.14",
                         "drawing.shape=circle",
                         "drawing.placement.scale=0.5",
                         "preflight.arm=false"};
  const Experiment e = prepare(resolve(options));
  RunData run;
  InkMatch drawn;
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < 60; ++i) {
    const double slope = i * std::numbers::pi / 180.0 + 0.005, around = 0.7 * i;
    const double error = 1e-5 * (1 + i);
    run.time.push_back(1e-3 * i);
    const Eigen::Vector3d n(std::sin(slope) * std::cos(around), std::sin(slope) * std::sin(around),
                            std::cos(slope));
    run.contact_point.push_back(Eigen::Vector3d(0.6, 0, 0) + 0.15 * n);
    drawn.error.push_back(i % 7 == 0 ? std::nan("") : error);
    if (i % 7 == 0 || slope >= std::numbers::pi / 4) continue;
    sum += error * error;
    ++count;
  }
  EXPECT_NEAR(gentle_error_mm(e, run, drawn, 45.0), 1e3 * std::sqrt(sum / count), 1e-9);
  EXPECT_TRUE(std::isnan(gentle_error_mm(e, run, drawn, 0.1)));
}

TEST(ReachJudge, ACrashIsALineWithItsCause) {
  const Record r = reach_record(named("koi-on-bowl"), {"", "crashed: signal 11", 3.0});
  EXPECT_EQ(r.at("verdict"), "crashed");
  EXPECT_EQ(r.at("cause"), "crashed: signal 11");
  EXPECT_EQ(r.at("failed"), "1");
  for (const auto& [name, value] : r)
    EXPECT_EQ(std::count(reach_columns().begin(), reach_columns().end(), name), 1) << name;
}

class Reach : public ScratchFolder {};

TEST_F(Reach, TheTenQuickestMeetTheirLimits) {
  std::vector<Cell> ten;
  for (const char* name :
       {"hand-on-ball", "hand-on-cone", "hand-on-leaning", "hand-on-wall", "hand-on-bowl",
        "hand-on-terrain", "hand-on-cylinder", "hand-on-tile", "logo-on-cone", "logo-on-ball"})
    ten.push_back(named(name));
  ASSERT_EQ(ten.size(), 10u);
  CellTableOptions options;
  options.out = folder_ / "out";
  options.jobs = 2;
  ASSERT_EQ(run_reach(ten, options), 0);
  const std::vector<Record> lines = read_csv(folder_ / "out/reach.csv");
  ASSERT_EQ(lines.size(), 10u);
  for (const Record& r : lines) {
    SCOPED_TRACE(r.at("cell"));
    EXPECT_EQ(r.at("failed"), "0") << r.at("verdict") << ": " << r.at("cause");
    EXPECT_NEAR(std::stod(r.at("promised")) + std::stod(r.at("undrawable")),
                std::stod(r.at("asked")), 0.2);
    EXPECT_EQ(r.at("reasons").empty(), std::stod(r.at("undrawable")) == 0.0);
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out/ink" / (r.at("cell") + ".json")));
    if (r.at("verdict") == "nothing") continue;
    EXPECT_GE(std::stod(r.at("coverage")), 0.995);
    if (!r.at("rms_to_45").empty()) {
      EXPECT_LE(std::stod(r.at("rms_to_45")), 0.2);
    }
    EXPECT_EQ(r.at("strokes_missed"), "0");
    EXPECT_EQ(r.at("lacking"), "0");
    EXPECT_GT(std::stod(r.at("simulated_time")), 1.0);
  }
  EXPECT_THAT(content_of(folder_ / "out/reach.md"),
              HasSubstr("10 of 100 combinations were run, and **0 missed a limit**"));
  EXPECT_GT(std::filesystem::file_size(folder_ / "out/reach.png"), 10000u);

  // Kept, unless its picture is gone.
  const std::string whole = content_of(folder_ / "out/reach.csv");
  ASSERT_EQ(run_reach(ten, options), 0);
  EXPECT_EQ(content_of(folder_ / "out/reach.csv"), whole);
}

TEST_F(Reach, TheListAndBadInput) {
  const Ended list = Process(folder_, {"reach", "--list"}).wait();
  EXPECT_EQ(list.code, 0);
  EXPECT_EQ(std::count(list.out.begin(), list.out.end(), '\n'), 200);
  EXPECT_THAT(list.out,
              HasSubstr("./impedraw draw scenarios/reach-wall.yaml --svg artwork/koi.svg\n"));
  const Ended none = Process(folder_, {"reach", "--only", "no-such-cell"}).wait();
  EXPECT_EQ(none.code, 2);
  EXPECT_EQ(std::count(none.err.begin(), none.err.end(), '\n'), 1) << none.err;
}

}  // namespace
}  // namespace impedraw

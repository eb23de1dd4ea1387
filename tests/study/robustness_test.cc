// The matrix of ./impedraw robustness: all cells that were asked for, each a scenario that can be
// run alone, and a table that loses none.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <numbers>
#include <set>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/metrics/metrics.h"
#include "impedraw/study/robustness.h"
#include "impedraw/study/robustness_run.h"
#include "impedraw/study/robustness_table.h"
#include "process.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::vector<Cell> group(const std::string& name) {
  std::vector<Cell> cells = robustness_cells();
  std::erase_if(cells, [&](const Cell& c) { return c.group != name; });
  return cells;
}

std::vector<Cell> named(const std::set<std::string>& names) {
  std::vector<Cell> cells = robustness_cells();
  std::erase_if(cells, [&](const Cell& c) { return !names.contains(c.name); });
  EXPECT_EQ(cells.size(), names.size());
  return cells;
}

bool is_realistic(const Scenario& s) {
  return s.control.source == WrenchSource::realistic && s.perception.noise.sigma_at_1m == 0.001 &&
         s.world.joint_friction == 1.0 && s.world.errors.mass_scale == 1.1;
}

TEST(RobustnessCells, TheMatrixHasEveryCombinationOnce) {
  std::vector<Scenario> scenarios;
  for (const Cell& cell : group("matrix")) scenarios.push_back(cell_scenario(cell));
  EXPECT_EQ(scenarios.size(), 120u);
  for (const double speed : {0.010, 0.050, 0.100, 0.200})
    for (const double slope : {0.0, 15.0, 30.0, 45.0, 60.0})
      for (const double push : {1.0, 5.0, 20.0})
        for (const bool realistic : {false, true}) {
          const auto is_it = [&](const Scenario& s) {
            const double angle =
                std::acos(s.canvas.plane.normal.normalized().z()) * 180.0 / std::numbers::pi;
            return s.canvas.kind == CanvasKind::plane && s.path.draw_speed == speed &&
                   std::abs(angle - slope) < 1e-5 && s.control.normal_force == push &&
                   is_realistic(s) == realistic;
          };
          EXPECT_EQ(std::count_if(scenarios.begin(), scenarios.end(), is_it), 1)
              << speed << " " << slope << " " << push << " " << realistic;
        }
}

// Read off the resolved settings: what is at another value than the standard sine's, and nothing
// else.
TEST(RobustnessCells, EachErrorStandsAloneAtThreeValues) {
  std::map<std::string, std::set<std::string>> values;
  for (const Cell& cell : group("error")) {
    Cell without = cell;  // but for what is said of all cells
    const auto own =
        std::find(without.assignments.begin(), without.assignments.end(), "drawing.redraw=false");
    ASSERT_NE(own, without.assignments.end());
    const bool none = own == without.assignments.begin();
    without.assignments.erase(without.assignments.begin(), own);
    const auto right = flat_settings(cell_scenario(without)),
               wrong = flat_settings(cell_scenario(cell));
    int changed = 0;
    for (const auto& [name, value] : wrong) {
      if (value == right.at(name)) continue;
      ++changed;
      EXPECT_TRUE(values[name].insert(value).second) << cell.name;
    }
    EXPECT_EQ(changed, none ? 0 : 1) << cell.name;
  }
  for (const char* name : {"mass_scale", "centre_shift", "viscous_friction", "rotor_inertia",
                           "torque_ripple", "torque_quantum", "loop_delay", "pen_longer"})
    EXPECT_EQ(values[std::string("world.errors.") + name].size(), 3u) << name;
  for (const char* name : {"world.joint_friction", "world.tip.friction", "world.tip.stiffness",
                           "perception.noise.sigma_at_1m", "wrench_sensor.noise_force"})
    EXPECT_EQ(values[name].size(), 3u) << name;
}

// One setting differs from its scenario's; and the delay that is no longer told, where it says so.
TEST(RobustnessCells, EachErrorUnderTheTuningForRealArmsAtThreeValues) {
  std::map<std::string, int> cells;
  for (const Cell& cell : group("tuned")) {
    Cell without = cell;
    const auto own =
        std::find(without.assignments.begin(), without.assignments.end(), "drawing.redraw=false");
    without.assignments.erase(without.assignments.begin(), own);
    const auto right = flat_settings(cell_scenario(without)),
               wrong = flat_settings(cell_scenario(cell));
    std::set<std::string> changed;
    for (const auto& [name, value] : wrong)
      if (value != right.at(name)) changed.insert(name);
    const bool untold = changed.erase("control.joint_sensing.sensor_delay") +
                            changed.erase("control.sensing.sensor_delay") >
                        0;
    EXPECT_EQ(untold, cell.name.ends_with("-untold")) << cell.name;
    if (cell.name == "tuned-as-it-is") {
      EXPECT_TRUE(changed.empty());
      continue;
    }
    // a row may also have the scenario's own value
    ASSERT_LE(changed.size(), 1u) << cell.name;
    const std::string& assignment = cell.assignments.front();
    const std::string name = assignment.substr(0, assignment.find('='));
    if (!changed.empty()) {
      EXPECT_EQ(*changed.begin(), name);
    }
    ++cells[name];
  }
  for (const char* name :
       {"perception.errors.shift", "perception.errors.turn", "perception.errors.depth_scale",
        "world.errors.pen_longer", "world.tip.stiffness", "world.tip.friction",
        "world.errors.loop_delay", "world.joint_sensor.quantum",
        "world.joint_sensor.velocity_noise", "world.joint_sensor.delay", "wrench_sensor.delay"})
    EXPECT_EQ(cells[name], 3) << name;
}

TEST(RobustnessCells, EveryKindOfCanvasNominalAndRealistic) {
  std::map<CanvasKind, std::set<bool>> kinds;
  for (const Cell& cell : group("canvas")) {
    const Scenario s = cell_scenario(cell);
    EXPECT_EQ(s.path.draw_speed, 0.05);
    EXPECT_EQ(s.control.normal_force, 5.0);
    EXPECT_EQ(is_realistic(s), cell.realistic) << cell.name;
    kinds[s.canvas.kind].insert(cell.realistic);
  }
  for (const CanvasKind kind :
       {CanvasKind::bowl, CanvasKind::dome, CanvasKind::plane, CanvasKind::wave, CanvasKind::saddle,
        CanvasKind::cylinder, CanvasKind::trough, CanvasKind::cone, CanvasKind::terrain})
    EXPECT_EQ(kinds[kind].size(), 2u);
}

TEST(RobustnessCells, EachSwitchIsOffAndOn) {
  std::map<std::string, std::set<std::string>> rows;
  for (const Cell& cell : group("switch")) {
    const Scenario s = cell_scenario(cell);
    const bool on = cell.row.starts_with("observer") ? s.control.observer.enabled
                    : cell.row.starts_with("force")  ? s.control.force_integral.enabled
                                                     : s.control.friction.coefficient > 0.0;
    EXPECT_EQ(on, cell.column == "on") << cell.name;
    rows[cell.row].insert(cell.column);
  }
  EXPECT_GE(rows.size(), 9u);
  for (const auto& [row, columns] : rows) EXPECT_EQ(columns.size(), 2u) << row;
}

TEST(RobustnessCells, NamesAndPlacesInTheTableAreUnique) {
  std::set<std::string> names, places;
  for (const Cell& cell : robustness_cells()) {
    EXPECT_TRUE(names.insert(cell.name).second) << cell.name;
    EXPECT_TRUE(places.insert(cell.table + "|" + cell.row + "|" + cell.column).second) << cell.name;
    EXPECT_EQ(cell.name.find_first_of(" ,;\"'"), std::string::npos) << cell.name;
    EXPECT_THAT(cell_command(cell), StartsWith("./impedraw draw " + cell.base));
  }
}

// RFC 4180, by hand.
TEST(RobustnessCsv, FieldsAreQuotedAndReadBack) {
  EXPECT_EQ(csv_line({"a", "", "b,c", "say \"no\"", "two\nlines", "[1, 2]"}),
            "a,,\"b,c\",\"say \"\"no\"\"\",two lines,\"[1, 2]\"\n");
}

class Robustness : public ScratchFolder {
 protected:
  std::vector<Record> csv() const { return read_csv(folder_ / "out/robustness.csv"); }
  CellTableOptions options() const {
    CellTableOptions o;
    o.out = folder_ / "out";
    o.jobs = 2;
    return o;
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "out"))
      names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }
};

TEST_F(Robustness, WhatIsCutOffIsNotRead) {
  write("torn.csv",
        "cell,failed,cause\nfirst,0,\nsecond,1,\"slow: \"\"so\"\", so\"\nthird,0\nfourth,1,re");
  const std::vector<Record> records = read_csv(folder_ / "torn.csv");
  ASSERT_EQ(records.size(), 2u);
  EXPECT_EQ(records[1].at("cause"), "slow: \"so\", so");
}

TEST_F(Robustness, TenCellsAreRunAndThenKept) {
  const std::vector<Cell> ten =
      named({"matrix-nominal-200mm_s-0deg-5N", "matrix-nominal-200mm_s-60deg-20N",
             "matrix-nominal-100mm_s-45deg-1N", "matrix-realistic-200mm_s-30deg-5N",
             "matrix-realistic-100mm_s-60deg-1N", "canvas-plane_at_30_deg-nominal",
             "canvas-sphere_outside_to_60_deg-nominal", "canvas-cone_around_it-realistic",
             "error-mass_scale-1.2", "error-loop_delay-0.002"});
  const std::vector<Cell> all = robustness_cells();
  ASSERT_EQ(run_matrix(all, ten, options()), 0);
  const std::vector<Record> first = csv();
  ASSERT_EQ(first.size(), 10u);
  for (const Record& r : first) {
    EXPECT_EQ(r.at("failed"), "0") << r.at("cell") << ": " << r.at("cause");
    for (const char* name :
         {"control.normal_force", "path.draw_speed", "canvas.kind", "world.errors.mass_scale",
          "world.tip.friction", "set", "control.observer.enabled", "ink_error_rms", "force_sd",
          "speed_mean", "tilt_mean", "slope", "wall_time"})
      EXPECT_NE(r.at(name), "") << r.at("cell") << ": " << name;
    for (const MetricDefinition& m : metric_definitions())
      EXPECT_TRUE(r.contains(m.name)) << m.name;
    EXPECT_GE(std::stod(r.at("speed_mean")), 0.9 * std::stod(r.at("speed")));
    if (r.at("cell").starts_with("matrix")) {
      EXPECT_THAT(r.at("cell"),
                  HasSubstr("-" + std::to_string(std::lround(std::stod(r.at("slope")))) + "deg-"));
    }
  }
  EXPECT_EQ(files(),
            (std::vector<std::string>{"robustness.csv", "robustness.md", "robustness.png"}));
  const std::string page = content_of(folder_ / "out/robustness.md");
  EXPECT_THAT(page, HasSubstr("not run"));
  EXPECT_THAT(page, HasSubstr(std::to_string(all.size()) + " cells, of which 10 were run"));

  // The same scenario by itself, in this process, gives what the cell's own process found.
  const CellResult alone = run_cell(ten.front(), folder_ / "alone.h5");
  const auto same = std::find_if(first.begin(), first.end(),
                                 [&](const Record& r) { return r.at("cell") == ten.front().name; });
  const double rms = alone.metrics.at("ink_error_rms");
  EXPECT_NEAR(std::stod(same->at("ink_error_rms")), rms, 1e-5 * rms);

  // Kept: not a character differs, times included. But for a line that was cut off: its cell is run
  // again.
  const std::string whole = content_of(folder_ / "out/robustness.csv");
  ASSERT_EQ(run_matrix(all, ten, options()), 0);
  EXPECT_EQ(content_of(folder_ / "out/robustness.csv"), whole);
  std::ofstream(folder_ / "out/robustness.csv", std::ios::binary)
      << whole.substr(0, whole.size() - 40);
  ASSERT_EQ(run_matrix(all, ten, options()), 0);
  const std::string repaired = content_of(folder_ / "out/robustness.csv");
  EXPECT_EQ(csv().size(), 10u);
  EXPECT_EQ(repaired.substr(0, repaired.find('\n', whole.size() / 2)),
            whole.substr(0, whole.find('\n', whole.size() / 2)));
}

Cell invented(const std::string& name, const std::vector<std::string>& assignments) {
  Cell cell = named({"matrix-nominal-200mm_s-0deg-5N"}).front();
  cell.name = name;
  cell.row = name;
  cell.assignments = assignments;
  return cell;
}

TEST_F(Robustness, WhatFailsIsALineWithItsCause) {
  const std::vector<Cell> cells = {
      invented("far", {"drawing.placement.centre=[0.6, 1.5]"}),
      invented("idle", {"path.draw_speed=0.2", "path.draw_acceleration=0.1"}),
      invented("hard", {"path.draw_speed=0.2", "world.tip.stiffness=1e7"})};
  ASSERT_EQ(run_matrix(cells, cells, options()), 0);
  const std::vector<Record> lines = csv();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_THAT(lines[0].at("cause"), StartsWith("refused: "));
  EXPECT_THAT(lines[0].at("cause"), Not(HasSubstr(IMPEDRAW_SOURCE)))
      << "the table is to be the same wherever it is made";
  EXPECT_EQ(lines[0].at("ink_error_rms"), "");
  EXPECT_EQ(lines[0].at("drawing.placement.centre"), "[0.6, 1.5]");
  EXPECT_THAT(lines[1].at("cause"), StartsWith("slow: "));
  EXPECT_GT(std::stod(lines[1].at("speed_mean")), 0.0);
  for (const Record& line : lines) EXPECT_EQ(line.at("failed"), "1") << line.at("cell");
  EXPECT_THAT(content_of(folder_ / "out/robustness.md"),
              HasSubstr("--set 'drawing.placement.centre=[0.6, 1.5]'"));
}

TEST_F(Robustness, WhatTakesTooLongIsEnded) {
  std::vector<ProcessEnd> ends;
  ProcessHooks hooks;
  hooks.finished = [&](std::size_t, const ProcessEnd& end) { ends.push_back(end); };
  const Cell cell = named({"matrix-nominal-10mm_s-60deg-5N"}).front();
  const auto work = [&](std::size_t, const std::filesystem::path& log) {
    return result_text(run_cell(cell, log));
  };
  EXPECT_TRUE(run_processes(1, work, {1, 0.05, folder_}, hooks));
  ASSERT_EQ(ends.size(), 1u);
  EXPECT_THAT(result_of(ends[0]).cause, StartsWith("timeout"));
  EXPECT_TRUE(std::filesystem::is_empty(folder_)) << "its log stays behind";
}

TEST_F(Robustness, CtrlCKeepsWhatWasDone) {
  Process program(
      folder_, {"robustness", "--only", "^matrix-nominal-200mm_s", "--out", "out", "--jobs", "1"});
  const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(10);
  while (program.running() && std::chrono::steady_clock::now() < limit && csv().empty())
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  program.signal(SIGINT);
  const Ended ended = program.wait();
  EXPECT_EQ(ended.code, 130) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("kept"));
  EXPECT_GE(csv().size(), 1u);
  EXPECT_LT(csv().size(), 15u);
  EXPECT_EQ(files(), std::vector<std::string>{"robustness.csv"});
}

TEST_F(Robustness, BadInputIsOneLine) {
  std::filesystem::create_directories(folder_ / "out");
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"robustness", "--only", "no-such-cell"},
        {"robustness", "--only", "("},
        {"robustness", "--jobs", "0"}}) {
    const Ended ended = Process(folder_, arguments).wait();
    EXPECT_EQ(ended.code, 2) << ended.err;
    EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
  }
  write("mine/notes.txt", "");
  const Ended full = Process(folder_, {"robustness", "--out", "mine"}).wait();
  EXPECT_EQ(full.code, 2);
  EXPECT_THAT(full.err, HasSubstr("robustness.csv"));
}

}  // namespace
}  // namespace impedraw

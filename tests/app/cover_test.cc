// ./impedraw cover: a short run on the dome, and bad input, which is named before anything moves.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>

#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace impedraw {
namespace {

namespace fs = std::filesystem;

class Cover : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("cover_test_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    std::ofstream(folder_ / "window.svg")
        << R"(<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="60mm">)"
        << R"(<rect width="90mm" height="60mm"/></svg>)";
  }
  void TearDown() override { fs::remove_all(folder_); }

  int run(const std::string& arguments, const std::string& what = "cover") {
    const std::string command = std::string(IMPEDRAW) + " " + what + " --out " + folder_.string() +
                                "/run " + arguments + " > " + folder_.string() + "/out 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  }
  std::string said() const {
    std::stringstream text;
    text << std::ifstream(folder_ / "out").rdbuf();
    return text.str();
  }
  std::string window(const std::string& scale) const {
    return "--region " + (folder_ / "window.svg").string() +
           " --set drawing.placement.scale=" + scale;
  }

  // The dome of scenarios/cover-dome.yaml as squares of 5 mm, red in a window of 60 × 60 mm about
  // its middle and else grey, moved along x [m].
  std::string painted(double moved) const {
    constexpr int kHalf = 16;
    constexpr double kSquare = 5e-3;
    std::ofstream out(folder_ / "painted.obj");
    for (int i = -kHalf; i <= kHalf; ++i)
      for (int j = -kHalf; j <= kHalf; ++j) {
        const double x = i * kSquare, y = j * kSquare;
        out << "v " << 0.6 + x + moved << " " << y << " " << std::sqrt(0.09 - x * x - y * y) - 0.1
            << (std::max(std::abs(i), std::abs(j)) <= 6 ? " 0.8 0.1 0.1\n" : " 0.5 0.5 0.5\n");
      }
    const int n = 2 * kHalf + 1;
    for (int i = 0; i + 1 < n; ++i)
      for (int j = 1; j < n; ++j) {
        const int a = i * n + j, b = a + n;
        out << "f " << a << " " << b << " " << b + 1 << "\nf " << a << " " << b + 1 << " " << a + 1
            << "\n";
      }
    return (folder_ / "painted.obj").string() + "#cc1a1a";
  }

  fs::path folder_;
};

TEST_F(Cover, TreatsAWindowOfTheDome) {
  ASSERT_EQ(run(window("1")), 0) << said();
  const auto metrics = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
  EXPECT_GT(metrics["treated_share"], 0.995);
  EXPECT_GT(metrics["promised_share"], 0.9);
  EXPECT_EQ(said().find("coverage"), std::string::npos) << said();  // a pad leaves no line
  EXPECT_NEAR(metrics["force_mean"], 5.0, 0.1);
  EXPECT_LT(metrics["force_sd"], 0.3);
  EXPECT_LT(metrics["removal_map_error"], 0.05);
  EXPECT_EQ(metrics["unsaid_share"], 0.0);
  EXPECT_TRUE(fs::exists(folder_ / "run/cover.png"));
  // Its middle lies at drawing.placement.centre.
  std::ifstream lines(folder_ / "run/cover.csv");
  std::string row;
  std::getline(lines, row);
  double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9}, at[2];
  while (std::getline(lines, row)) {
    ASSERT_EQ(std::sscanf(row.c_str(), "%lf,%lf", &at[0], &at[1]), 2);
    for (int i = 0; i < 2; ++i)
      low[i] = std::min(low[i], at[i]), high[i] = std::max(high[i], at[i]);
  }
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(0.5 * (low[i] + high[i]), 0.0, 2.0);
  EXPECT_NEAR(high[0] - low[0], 90.0 - 32.0, 3.0);
  EXPECT_NEAR(high[1] - low[1], 60.0 - 32.0, 3.0);
}

// A window hardly wider than the pad has no place that is a radius off its border.
TEST_F(Cover, TellsNoEvennessWhereAllIsRim) {
  ASSERT_EQ(run(window("0.54") + " --set control.normal_force=8"), 0) << said();
  const auto metrics = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
  EXPECT_TRUE(metrics["removal_cv"].is_null()) << metrics["removal_cv"];
  EXPECT_TRUE(metrics["removal_map_error"].is_null()) << metrics["removal_map_error"];
  EXPECT_GT(metrics["removal_cv_to_edge"], 0.0);
  EXPECT_NE(said().find("with the rim of one radius, which is all"), std::string::npos) << said();
}

TEST_F(Cover, SpraysAWindowOfTheDome) {
  ASSERT_EQ(run(window("1") + " --set tool.kind=nozzle --set tool.stand_off=0.06"), 0) << said();
  const auto metrics = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
  EXPECT_GT(metrics["treated_share"], 0.995);
  EXPECT_GT(metrics["promised_share"], 0.9);
  EXPECT_LT(metrics["coat_cv"], 0.1);
  EXPECT_LT(metrics["coat_map_error"], 0.05);
  EXPECT_LT(metrics["stand_off_error_rms"], 1.0);
  EXPECT_FALSE(metrics.contains("pressure_mean"));
  EXPECT_TRUE(metrics["force_mean"].is_null()) << metrics["force_mean"];
}

// From a third of the most on the left to all of it on the right, in two passes.
TEST_F(Cover, RemovesAsTheTonesSay) {
  std::ofstream(folder_ / "window.svg")
      << R"svg(<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="60mm">)svg"
      << R"svg(<linearGradient id="g"><stop offset="0" stop-color="#aaa"/><stop offset="1"/>)svg"
      << R"svg(</linearGradient><rect width="90mm" height="60mm" fill="url(#g)" /></svg>)svg";
  ASSERT_EQ(run(window("1") + " --set cover.dose=by_tone --set cover.passes=2"), 0) << said();
  const auto whole = nlohmann::json::parse(std::ifstream(folder_ / "run/cover.json"));
  EXPECT_GT(whole["metrics"]["treated_share"], 0.995);
  EXPECT_LT(whole["metrics"]["removal_cv"], 0.1);
  EXPECT_LT(whole["metrics"]["removal_map_error"], 0.05);
  // The log tells as much.
  ASSERT_EQ(run(window("1") + " --set cover.dose=by_tone --set cover.passes=2 --resume"), 0);
  const auto again = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
  EXPECT_NEAR(again["treated_share"], whole["metrics"]["treated_share"], 0.002) << said();
  EXPECT_EQ(run(window("1") + " --set cover.dose=by_tone --set tool.kind=nozzle --overwrite"), 2);
  EXPECT_NE(said().find("by_tone varies the force of a pad"), std::string::npos) << said();
  EXPECT_EQ(run("--set cover.dose=by_tone --overwrite"), 2);
  EXPECT_NE(said().find("cover.region is not given"), std::string::npos) << said();
}

// The pad stands on the surface where that bends most of what its foam allows.
TEST_F(Cover, StaysLevelOnATube) {
  ASSERT_EQ(run("--set canvas.kind=cylinder --set canvas.cylinder.radius=0.045 "
                "--set canvas.cylinder.width=0.075 --set canvas.cylinder.length=0.12"),
            0)
      << said();
  const auto metrics = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
  EXPECT_GT(metrics["treated_share"], 0.995);
  EXPECT_LT(metrics["force_sd"], 0.35);
  EXPECT_LT(metrics["removal_cv"], 0.08);
}

// What is too rough for a tip lies under the face of a pad, whose foam gives way.
TEST_F(Cover, RoughGroundCutsNoLine) {
  ASSERT_EQ(run(window("1") + " --set canvas.kind=rough"), 0) << said();
  const auto strokes = nlohmann::json::parse(std::ifstream(folder_ / "run/strokes.json"));
  EXPECT_TRUE(strokes["not_drawable"].empty()) << strokes["not_drawable"];
  EXPECT_EQ(said().find("the pre-flight refuses"), std::string::npos) << said();
  const auto metrics = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
  EXPECT_GT(metrics["treated_share"], 0.995);
}

// A third of the window lies beyond the arm's reach: lines that are cut there promise 38 cm², and
// lines that are laid anew on what is left of them 61.
TEST_F(Cover, KeepsItsLinesWithinTheReach) {
  ASSERT_EQ(run(window("1.3") + " --set canvas.cap.centre=[0.80,0,-0.1] "
                                "--set drawing.placement.centre=[0.80,0]"),
            0)
      << said();
  const auto whole = nlohmann::json::parse(std::ifstream(folder_ / "run/cover.json"));
  EXPECT_GT(whole["metrics"]["treated_share"], 0.995);
  EXPECT_LT(whole["metrics"]["removal_cv"], 0.12);
  EXPECT_GT(whole["areas_cm2"]["promised"], 62.0);
  EXPECT_NEAR(whole["areas_cm2"]["reachable"], 65.0, 3.0);  // of 84 that the pad fits
  EXPECT_NE(said().find("or where the arm does not reach"), std::string::npos) << said();
}

// A hand lifts the pad for a while: nothing stays untreated and unsaid. As it let go of 15 N, the
// light tip's answer was taken for a made-up wrench, and the run ended.
TEST_F(Cover, KnowsWhatAHandHindered) {
  for (const std::string lift : {"12", "15"}) {
    SCOPED_TRACE(lift + " N");
    ASSERT_EQ(run(window("1") + " --overwrite --set 'pushes=[{force: 0, lift: " + lift +
                  ", middle: 0.5, duration: 0.6}]'"),
              0)
        << said();
    const auto metrics = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
    EXPECT_GT(metrics["treated_share"], 0.995);
    EXPECT_EQ(metrics["unsaid_share"], 0.0);
  }
}

// A groove in a material that is a fifth harder than believed, and in a fifth softer.
TEST_F(Cover, AnEngraverHoldsItsDepth) {
  for (const std::string hardness : {"1.2", "0.8"}) {
    ASSERT_EQ(run("scenarios/bowl-engrave-real.yaml --set drawing.shape=circle "
                  "--set tool.hardness=" +
                      hardness + " --overwrite",
                  "draw"),
              0)
        << said();
    const auto metrics = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
    EXPECT_LT(metrics["depth_error_rms"], 0.03) << hardness;
    EXPECT_NEAR(metrics["depth_mean"], 0.3, 0.01) << hardness;
    EXPECT_GT(metrics["coverage"], 0.99);
  }
  // A slim cone meets twice as much force across as along its axis: that is no wall.
  ASSERT_EQ(run("scenarios/bowl-engrave.yaml --set tool.half_angle=30 --overwrite", "draw"), 0);
  const auto slim = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
  EXPECT_LT(slim["depth_error_rms"], 0.02);
  EXPECT_LT(slim["ink_error_rms"], 0.03);
  EXPECT_EQ(run("scenarios/bowl-engrave.yaml --set tool.half_angle=10 --overwrite", "draw"), 2);
  EXPECT_NE(said().find("tool.half_angle: a cone of 10°"), std::string::npos) << said();
  EXPECT_EQ(run("scenarios/bowl-sine-blind.yaml --set tool.kind=engraver --overwrite", "draw"), 2);
  EXPECT_NE(said().find("tool.kind: an engraver holds its depth"), std::string::npos) << said();
}

// What was tried and did not go well is said before anything moves, and nothing of what did.
TEST_F(Cover, SaysWhatAnEngraverIsNotSureToHold) {
  const std::string real = "scenarios/bowl-engrave-real.yaml --set tool.depth=";
  ASSERT_EQ(run(real + "0.001", "plan"), 0) << said();
  EXPECT_NE(said().find("the ones deeper than 0.9 mm ended"), std::string::npos) << said();
  ASSERT_EQ(run(real + "0.0008", "plan"), 0) << said();
  EXPECT_EQ(said().find("tool.depth"), std::string::npos) << said();
  ASSERT_EQ(run("scenarios/moving-heave.yaml --set tool.kind=engraver", "plan"), 0) << said();
  EXPECT_NE(said().find("the canvas may move"), std::string::npos) << said();
}

// Of both parts of the run, and as `report` computes them again.
TEST_F(Cover, GoesOnAfterAnInterrupt) {
  const std::string begin = std::string(IMPEDRAW) + " cover --out " + folder_.string() + "/run > " +
                            folder_.string() + "/out 2>&1";
  const std::string kill = "while ! test -s " + folder_.string() +
                           "/run/run.h5; do sleep 0.05; done; sleep 0.5; kill -INT $p";
  ASSERT_EQ(
      WEXITSTATUS(std::system(("{ exec " + begin + "; } & p=$!; " + kill + "; wait $p").c_str())),
      130)
      << said();
  EXPECT_EQ(run(window("1") + " --resume"), 2);
  EXPECT_NE(said().find("was started with 'region: \"\"', now it is 'region: /"), std::string::npos)
      << said();
  // The same lines, gone along at another speed.
  EXPECT_EQ(run("--set path.draw_speed=0.05 --resume"), 2);
  EXPECT_NE(said().find("was started with 'draw_speed: 0.1', now it is 'draw_speed: 0.05'"),
            std::string::npos)
      << said();
  ASSERT_EQ(run("--resume"), 0) << said();
  const auto metrics = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
  EXPECT_GT(metrics["treated_share"], 0.995);
  EXPECT_GT(metrics["treated_share_known"], 0.995);
  const std::string report = std::string(IMPEDRAW) + " report " + folder_.string() + "/run > " +
                             folder_.string() + "/out 2>&1";
  ASSERT_EQ(std::system(report.c_str()), 0) << said();
  const auto again = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
  EXPECT_EQ(again["treated_share"], metrics["treated_share"]);
  EXPECT_EQ(again["force_mean"], metrics["force_mean"]);
}

// The later one replaced the lines of the one that was under way.
TEST_F(Cover, LeavesAFolderAloneThatAnotherOnePlansInto) {
  const auto start = [&](const std::string& scale) {
    return std::string(IMPEDRAW) + " cover --out " + (folder_ / "run").string() + " " +
           window(scale) + " > " + (folder_ / ("said" + scale)).string() + " 2>&1";
  };
  const std::string both = start("1") + " & p=$!; while ! test -e " +
                           (folder_ / "run/cover.csv").string() + "; do sleep 0.01; done; " +
                           start("0.8") + "; second=$?; wait $p && exit $second";
  EXPECT_EQ(WEXITSTATUS(std::system(both.c_str())), 2);
  std::stringstream lines, begun, said;
  lines << std::ifstream(folder_ / "run/cover.csv").rdbuf();
  begun << std::ifstream(folder_ / "run/inputs/cover.csv").rdbuf();
  said << std::ifstream(folder_ / "said0.8").rdbuf();
  EXPECT_EQ(lines.str(), begun.str());
  EXPECT_NE(said.str().find("writes there; wait until it has ended"), std::string::npos)
      << said.str();
}

// Killed while the pad presses: the sensor is tared off the surface, not on it.
TEST_F(Cover, GoesOnAfterItWasKilled) {
  const std::string cover = std::string(IMPEDRAW) + " cover --out " + folder_.string() + "/run > " +
                            folder_.string() + "/out 2>&1";
  const std::string kill = "while ! test -s " + folder_.string() +
                           "/run/run.h5; do sleep 0.05; done; sleep 0.5; kill -KILL $p";
  ASSERT_EQ(
      WEXITSTATUS(std::system(("{ exec " + cover + "; } & p=$!; " + kill + "; wait $p").c_str())),
      137)
      << said();
  ASSERT_EQ(run("--resume"), 0) << said();
  const auto metrics = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
  EXPECT_GT(metrics["treated_share"], 0.995);
  EXPECT_LT(metrics["removal_cv"], 0.06);
}

TEST_F(Cover, NamesBadInput) {
  const auto refuses = [&](const std::string& arguments, const std::string& words) {
    EXPECT_EQ(run(arguments), 2);
    EXPECT_NE(said().find(words), std::string::npos) << said();
    EXPECT_FALSE(fs::exists(folder_ / "run/run.h5"));
  };
  refuses("--set tool.kind=roller", "tool.kind");
  refuses("--set ''", "a value is missing");
  refuses("--set tool.kind=pen", "tool.kind is pen");
  refuses("--set perception.enabled=false", "perception.enabled is false");
  refuses(window("1") + " --set drawing.placement.centre=[1.5,0]", "lies off the canvas");
  refuses(window("0.3"), "fits nowhere in cover.region");
  refuses(window("1") + " --set drawing.layer=2", "no layer '2'");
  refuses("--set tool.foam_stiffness=1e8", "touches with a part of its face only");
  refuses("--set tool.radius=0.0075", "press the foam of a pad of 15.0 mm in by 14.1 mm");
  refuses("--set tool.joints=2 --set tool.pivot=0.02",
          "joints 26.5 mm above the surface slides on its edge, by control.friction 0.3; valid is "
          "tool.pivot up to 0.0122 m");
  refuses(
      "--set tool.joints=1 --set tool.radius=0.009 --set control.normal_force=3 "
      "--set tool.pivot=-0.019",
      "mm below the surface slides on its edge");
  refuses("--region part.ply#c0102", "a colour of six hexadecimal digits");
  refuses("--region " + painted(0.5), "canvas.mesh.position moves it");
  refuses("--set tool.depth=0.0005", "tool.depth is given, and tool.kind is pad");
  refuses("--set tool.kind=nozzle --set tool.radius=0.1", "has no room to move along a line");
}

// What is given with a scenario's own tool is not of another tool that is taken instead.
TEST_F(Cover, NamesSettingsOfAnotherTool) {
  EXPECT_EQ(run("scenarios/bowl-engrave.yaml --set tool.trail=0.001", "plan"), 2);
  EXPECT_NE(said().find("--set tool.trail=0.001: tool.trail is given, and tool.kind is engraver"),
            std::string::npos)
      << said();
  EXPECT_NE(said().find("valid is one of tool.depth, tool.half_angle, tool.passes, tool.hardness, "
                        "or tool.kind: blade, roller"),
            std::string::npos)
      << said();
  EXPECT_EQ(run("scenarios/bowl-engrave.yaml --set tool.kind=pen", "plan"), 0) << said();
  std::ofstream(folder_ / "mixed.yaml") << "name: mixed\ntool: {kind: pad, stand_off: 0.05}\n";
  EXPECT_EQ(run((folder_ / "mixed.yaml").string(), "plan"), 2);
  EXPECT_NE(said().find("mixed.yaml:2: tool.stand_off"), std::string::npos) << said();
  // A run writes the settings of every tool into its folder; they draw it again.
  fs::remove_all(folder_ / "run");
  const std::string again = (folder_ / "run/scenario.yaml").string();
  ASSERT_EQ(run("scenarios/cover-dome.yaml --set tool.kind=pen --set drawing.shape=circle", "draw"),
            0)
      << said();
  EXPECT_EQ(run(again + " --overwrite", "draw"), 0) << said();
}

// Lines that an earlier run left, which was ended before it drew, do not bar the folder.
TEST_F(Cover, StartsWhereOnlyLinesWereLaid) {
  fs::create_directories(folder_ / "run");
  std::ofstream(folder_ / "run/cover.csv") << "x,y,force,stroke\n";
  EXPECT_EQ(run(window("1") + " --resume"), 0) << said();
}

// A region's picture is no filled area: that is said, and the rest is covered.
TEST_F(Cover, SaysWhatOfARegionItLeavesOut) {
  std::ofstream(folder_ / "window.svg")
      << R"(<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="60mm">)"
      << R"(<rect width="90mm" height="60mm"/><image width="9" height="9" href="a.png"/></svg>)";
  ASSERT_EQ(run(window("1")), 0) << said();
  EXPECT_NE(said().find("note: cover.region: 1 × <image>"), std::string::npos) << said();
}

// A pad that touches about its middle alone, on a ball as large as its foam gives.
TEST_F(Cover, NamesAPadThatDoesNotFitALine) {
  EXPECT_EQ(run("scenarios/cover-dome.yaml --set drawing.shape=circle "
                "--set tool.foam_stiffness=1e8",
                "draw"),
            2);
  EXPECT_NE(said().find("touches about its middle alone"), std::string::npos) << said();
  // In the bowl it hangs on its rim.
  EXPECT_EQ(run("scenarios/bowl-sine.yaml --set tool.kind=pad --set tool.radius=0.05", "plan"), 2);
  EXPECT_NE(said().find("touches with its rim alone"), std::string::npos) << said();
  // The dome falls by 0.34 mm to the rim: it touches where 5 N press a foam in by half of that.
  const double area = std::numbers::pi * 0.015 * 0.015;
  for (const double of_half : {1.3, 0.8}) {
    const double stiffness = 5.0 / area / (of_half * 0.17e-3);
    run("scenarios/cover-dome.yaml --set drawing.shape=circle --set tool.foam_stiffness=" +
            std::to_string(stiffness),
        "plan");
    EXPECT_EQ(said().find("touches about its middle alone") == std::string::npos, of_half > 1.0)
        << said();
  }
}

TEST_F(Cover, CoversAColourOfAMesh) {
  ASSERT_EQ(run("--region " + painted(0.0) + " --set drawing.placement.rotate=45"), 0) << said();
  EXPECT_NE(said().find("--set drawing.placement.rotate=45: drawing.placement has no effect on "
                        "cover: cover.region is a mesh"),
            std::string::npos)
      << said();
  const auto metrics = nlohmann::json::parse(std::ifstream(folder_ / "run/metrics.json"));
  EXPECT_GT(metrics["treated_share"], 0.995);
  std::ifstream lines(folder_ / "run/cover.csv");
  std::string row;
  std::getline(lines, row);
  double x = 0.0, y = 0.0, most = 0.0;
  while (std::getline(lines, row)) {
    ASSERT_EQ(std::sscanf(row.c_str(), "%lf,%lf", &x, &y), 2);
    most = std::max({most, std::abs(x), std::abs(y)});
  }
  EXPECT_NEAR(most, 30.0 - 16.0, 3.0);
}

}  // namespace
}  // namespace impedraw

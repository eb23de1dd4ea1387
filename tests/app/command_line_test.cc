// The program as its user meets it at the terminal: what is wrong with the input, what it leaves
// behind, how it ends.
#include <pty.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <array>
#include <chrono>
#include <regex>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "impedraw/log/run_data.h"
#include "process.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using Words = std::vector<std::string>;
using Clock = std::chrono::steady_clock;

const Words kShort = {"--set", "path.draw_speed=0.3", "--set", "path.draw_acceleration=5"};
const Words kLong = {"--set", "path.draw_speed=0.0015"};  // 200 s of simulated time and more
const char* const kLine =
    R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">
    <path d="M5 5H15M5 35H35" fill="none" stroke="black"/></svg>)";

Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

nlohmann::json json_of(const fs::path& file) { return nlohmann::json::parse(content_of(file)); }

class CommandLine : public ScratchFolder {
 protected:
  Ended call(const Words& arguments) const { return Process(folder_, arguments).wait(); }
  Ended python(const std::string& script) const {
    const fs::path file = write("script.py", script);
    const int status = std::system((std::string(IMPEDRAW_PYTHON) + " " + file.string() + " > " +
                                    (folder_ / "said").string() + " 2>&1")
                                       .c_str());
    return {WEXITSTATUS(status), content_of(folder_ / "said"), ""};
  }
  // Names of what is in the test's folder, but for the output of the program.
  std::vector<std::string> left_behind() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      const std::string name = entry.path().lexically_relative(folder_);
      if (name != ".stdout" && name != ".stderr") names.push_back(name);
    }
    std::sort(names.begin(), names.end());
    return names;
  }
  void refused(const Words& arguments, const std::vector<std::string>& said) const {
    SCOPED_TRACE(::testing::PrintToString(arguments));
    const auto before = left_behind();
    const Ended ended = call(arguments);
    EXPECT_EQ(ended.code, 2);
    EXPECT_THAT(ended.out, IsEmpty());
    EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
    EXPECT_THAT(ended.err, ::testing::StartsWith("impedraw: "));
    for (const std::string& words : said) EXPECT_THAT(ended.err, HasSubstr(words));
    EXPECT_EQ(left_behind(), before);
  }
  // Until the run has its log.
  void until_running(const Process& process) const { until_size(process, "run/run.h5", 0); }
  // Until it draws: its journal has the rows of 4 s, about 1 kB each, and the pen touches before.
  void until_drawing(const Process& process) const {
    until_size(process, "run/run.journal", 4'000'000);
  }

 private:
  void until_size(const Process& process, const char* name, std::uintmax_t bytes) const {
    std::error_code none;
    const auto has = [&] {
      const std::uintmax_t size = fs::file_size(folder_ / name, none);
      return !none && size >= bytes;
    };
    for (int i = 0; i < 2000 && process.running() && !has(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
};

TEST_F(CommandLine, WrongSettings) {
  write("a.yaml", "drawing: {shape: sine}\npath:\n  draw_sped: 0.3\n");
  write("push.yaml", "name: x\ncontrol:\n  push: 70\n");
  write("nan.yaml", "control: {push: .nan}\n");
  refused({"draw", "a.yaml"}, {"a.yaml:3: unknown key 'draw_sped' in path", "'draw_speed'"});
  refused({"draw", "push.yaml"}, {"push.yaml:3: control.push is 70 N", "0 to 50 N"});
  refused({"draw", "nan.yaml"}, {"nan.yaml:1: control.push is .nan", "finite", "0 to 50 N"});
  refused({"draw", "--set", "control.push=nan"},
          {"--set control.push=nan: control.push is nan", "finite"});
  refused({"draw", "--set", "arm.start=[0.4, .inf, 0.5]"}, {"arm.start.1 is .inf"});
  refused({"draw", "--set", "control.psh=3"},
          {"--set control.psh=3: unknown key 'psh' in control", "'normal_force', formerly 'push'"});
  refused({"draw", "--set", "control.push"}, {"NAME=VALUE", "control.normal_force=3"});
  refused({"draw", "--set", "name=a/b"}, {"name is 'a/b'"});
}

TEST_F(CommandLine, WrongFiles) {
  write("broken.yaml", "drawing: {shape: sine\n  foo: [");
  write("empty.svg", R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"/>)");
  write("broken.svg", "<svg><path d=\"M 1");
  write("text", "x");
  write("svg.yaml", "drawing:\n  svg: gone.svg\n");
  refused({"draw", "gone.yaml"}, {"gone.yaml: no such file"});
  refused({"draw", "."}, {"is a folder"});
  refused({"draw", "broken.yaml"}, {"broken.yaml:2: is not valid YAML"});
  refused({"draw", "--svg", "gone.svg"}, {"gone.svg: no such file"});
  refused({"draw", "svg.yaml"}, {"svg.yaml:2: ", "gone.svg: no such file"});
  refused({"draw", "--svg", "broken.svg"}, {"broken.svg: cannot be read as SVG"});
  refused({"draw", "--svg", "empty.svg"}, {"empty.svg: has nothing to draw"});
  refused({"draw", "--set", "arm.urdf=text"}, {"--set arm.urdf=text", "text"});
  refused({"report", "."}, {"contains no run.h5"});
}

// A pipe without a writer would be waited for, a device would never end.
TEST_F(CommandLine, FilesThatAreNone) {
  for (const char* pipe : {"a.yaml", "a.svg", "a.csv", "a.obj", "a.urdf"})
    ASSERT_EQ(mkfifo((folder_ / pipe).c_str(), 0600), 0);
  const std::string said = "is a pipe, must be a regular file";
  refused({"plan", "a.yaml"}, {"a.yaml: " + said});
  write("b.yaml", "extends: a.yaml\n");
  refused({"plan", "b.yaml"}, {"b.yaml:1: extends a.yaml: " + said});
  refused({"plan", "--svg", "a.svg"}, {"a.svg: " + said});
  refused({"plan", "--svg", "a.csv"}, {"a.csv: " + said});
  refused({"plan", "--set", "canvas.kind=mesh", "--set", "canvas.mesh.file=a.obj"},
          {"a.obj: " + said});
  refused({"plan", "--set", "arm.urdf=a.urdf"}, {"a.urdf: " + said});
  refused({"plan", "/dev/zero"}, {"is a socket or a device"});
  refused({"inspect", "a.svg"}, {"a.svg: " + said});
}

TEST_F(CommandLine, SizesBeyondSense) {
  for (const char* size : {"scale=1000", "scale=1e300", "width=1e8", "height=1e8"})
    refused({"plan", "--shape", "circle", "--set", std::string("drawing.placement.") + size},
            {size, "from its centre, allowed is at most 10 m"});
  std::string dots, far;
  for (int i = 0; i < 100'001; ++i)
    dots += std::to_string(i % 300) + "," + std::to_string(i) + "\n\n";
  for (int i = 0; i < 20'000; ++i)
    far += std::to_string(i % 2 * 200) + "," + std::to_string(0.01 * i) + "\n";
  write("dots.csv", dots);
  write("far.csv", far);
  refused({"plan", "--svg", "dots.csv"}, {"dots.csv: 100001 strokes, at most 100000 are drawn"});
  refused({"plan", "--svg", "far.csv", "--set", "drawing.placement.scale=1"},
          {"m of strokes, at most 1000 m are drawn"});
}

TEST_F(CommandLine, DrawingWhereItCannotBe) {
  write("two.svg", kLine);
  refused({"draw", "--set", "drawing.placement.centre=[0.7, 0.1]"},
          {"stroke 0 leaves the canvas, as the cameras see it: 9", "world (0.7000, 0.2500, "});
  // x = 0.72 m − 10 Y: its first stroke lies at 0.67 m, its second at 0.37 m, outside the rim.
  refused({"draw", "--svg", "two.svg", "--set", "drawing.placement.scale=10", "--set",
           "drawing.placement.centre=[0.72, 0.05]", "--set",
           "drawing.placement.about_page_origin=true"},
          {"stroke 1 leaves the canvas, as the cameras see it: ", "world (0.3700, "});
  refused({"draw", "--shape", "m"}, {"--shape m: ", "did you mean 'M'?", "sine, sine10"});
  refused({"draw", "--set", "drawing.shape=cosine"},
          {"drawing.shape is 'cosine'", "M, sine, sine10"});
  refused({"draw", "--set", "path.turn_speed=5"},
          {"--set path.turn_speed", "above control.turn_speed_limit, 4 rad/s"});
  refused({"draw", "--set", "control.turn_speed_limit=1.2"},
          {"--set control.turn_speed_limit", "below the 1.5 rad/s"});
  // The iiwa 14 with its pen reaches about 1 m from its shoulder.
  for (const char* blind : {"true", "false"})
    refused(
        {"draw", "--set", "canvas.cap.centre=[1.8, 0, 0.4]", "--set",
         "drawing.placement.centre=[1.8, 0]", "--set", "perception.region_upper=[2.5, 0.3, 0.35]",
         "--set", std::string("perception.enabled=") + blind},
        {"stroke 0 leaves the arm's reach: the tip stays ", "world (1.", "mm"});
}

TEST_F(CommandLine, SettingsThatDoNotGoTogether) {
  write("none.yaml", "name: none\ncontrol:\n  wrench: none\n");
  refused({"draw", "none.yaml"},
          {"none.yaml:3: ", "'shaped' needs a measured wrench", "'natural'"});
  refused({"draw", "--set", "control.mass_normal=0.05"},
          {"--set control.mass_normal=0.05: inertia along the normal", "limit"});
  refused({"draw", "--set", "control.contact.leave_distance=0.0005"},
          {"control.contact.leave_distance=0.0005: ", "is a constant: 0.0025 m"});
  refused({"draw", "--set", "perception.normals.mode=interpolated"},
          {"perception.normals.mode=interpolated: ", "is a constant: fresh"});
  refused({"draw", "--set", "arm.q_0=[0, 0]"}, {"arm.q_0 has 2 entries, but the arm"});
  refused({"draw", "--set", "perception.region_lower=[0.95, -0.3, 0]"}, {"region"});
  refused({"draw", "--set", "perception.region_lower=[0.6, -0.3, 0]"}, {"as the cameras see it"});
  refused({"draw", "--no-perception", "--set", "control.stiffness_normal=0"},
          {"control.stiffness_normal is 0 N/m", "more than 0"});
  // Only the second run of the two is wrong, and neither is made.
  refused({"compare", "--out", "both", "--set", "control.stiffness_normal=0"},
          {"control.stiffness_normal is 0 N/m"});
}

// strokes.json tells why a part has no ink. A hand that holds the pen back is felt as a wall; there
// the stroke is given up, and the rest is drawn. Without a cloud the pen retreats.
TEST_F(CommandLine, WhyAPartHasNoInk) {
  const std::string scenarios = IMPEDRAW_SOURCE "/scenarios/";
  const struct {
    const char* scenario;
    Words settings;
    const char* reason;
    double length;  // that lacks ink, at most [mm]
  } cases[] = {{"bowl-push",
                {"--set", "pushes.0.force=20", "--set", "pushes.0.direction=[-0.902, -0.431, 0]",
                 "--set", "pushes.0.duration=2"},
                "wall",
                10},
               {"safety-no-cloud", {}, "no_ink", 260}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.reason);
    const Words draw = {"draw", scenarios + c.scenario + ".yaml", "--out", c.scenario};
    ASSERT_EQ(call(draw + c.settings).code, 0);
    const nlohmann::json lacking = json_of(folder_ / c.scenario / "strokes.json").at("lacking");
    ASSERT_EQ(lacking.size(), 1u);
    EXPECT_EQ(lacking[0].at("reason"), c.reason);
    const double length =
        lacking[0].at("to_mm").get<double>() - lacking[0].at("from_mm").get<double>();
    EXPECT_GT(length, 1.0);
    EXPECT_LT(length, c.length);
  }
}

// At the foot of a step of 30 mm two sides meet like an open book.
TEST_F(CommandLine, PlanNamesACrease) {
  const Ended ended = call({"plan", "--json", "--shape", "M", "--set", "canvas.kind=rough", "--set",
                            "canvas.rough.form=step", "--set", "canvas.rough.rise=0.03"});
  EXPECT_EQ(ended.code, 1) << ended.err;
  int creases = 0;
  const nlohmann::json plan = nlohmann::json::parse(ended.out);
  for (const nlohmann::json& part : plan.at("not_drawable")) {
    if (part.at("problem") != "crease") continue;
    ++creases;
    EXPECT_THAT(part.at("text").get<std::string>(), HasSubstr("two sides of the surface meet"));
    EXPECT_NEAR(part.at("world_m")[0].get<double>(), 0.6, 0.01) << "where the step is";
  }
  EXPECT_GT(creases, 0);
}

// A handle of 16 mm, in the middle of the whole, and a blade of 140 × 120 mm.
TEST_F(CommandLine, WhatFitsNowhereInTheMiddleGoesElsewhereOnTheObject) {
  std::string mesh;
  int first = 1;
  const auto box = [&](double x0, double x1, double y0, double y1, double top) {
    for (const double x : {x0, x1})
      for (const double y : {y0, y1})
        for (const double z : {0.0, top}) mesh += fmt::format("v {} {} {}\n", x, y, z);
    // Corners by bits: 4 for x, 2 for y, 1 for z.
    for (const auto& [a, b, c, d] : {std::array{0, 1, 3, 2},
                                     {4, 6, 7, 5},
                                     {0, 4, 5, 1},
                                     {2, 3, 7, 6},
                                     {0, 2, 6, 4},
                                     {1, 5, 7, 3}})
      mesh +=
          fmt::format("f {0} {1} {2}\nf {0} {2} {3}\n", first + a, first + b, first + c, first + d);
    first += 8;
  };
  box(-0.008, 0.008, -0.2, 0.08, 0.02);
  box(-0.07, 0.07, 0.08, 0.2, 0.03);
  write("paddle.obj", mesh);
  const Ended planned =
      call({"plan", "--text", "Hello", "--place", "auto", "--set", "canvas.kind=mesh", "--set",
            "canvas.mesh.file=paddle.obj", "--set", "canvas.move=[0.6, 0, 0.02]", "--set",
            "drawing.placement.fit_radius=0.06"});
  EXPECT_EQ(planned.code, 0);
  EXPECT_THAT(planned.out, HasSubstr("all of it can be drawn"));
  EXPECT_THAT(planned.err, HasSubstr("placed  the drawing's middle at"));
}

TEST_F(CommandLine, WrongOut) {
  write("file", "mine");
  write("foreign/mine.txt", "mine");
  write("own/scenario.yaml", "name: mine\n");  // a user's scenario is no run
  refused({"draw", "--out", "file"}, {"--out file: is a file"});
  refused({"draw", "--out", "file/x"}, {"--out file/x: ", "file is a file"});
  refused({"draw", "--out", "foreign"}, {"--out foreign: contains files but no run"});
  refused({"draw", "own/scenario.yaml", "--out", "own"}, {"--out own: contains files but no run"});
  refused({"draw", "--out", "/proc/x"}, {"--out /proc/x: "});
  refused({"compare", "--out", "foreign"}, {"--out foreign: contains files but no comparison"});
  EXPECT_EQ(content_of(folder_ / "own/scenario.yaml"), "name: mine\n");
}

// A folder that was named keeps its results; the default one is drawn into again.
TEST_F(CommandLine, ResultsAreReplacedOnRequestAlone) {
  const Words draw = Words{"draw", "--out", "run"} + kShort;
  ASSERT_EQ(call(draw).code, 0);
  const std::string log = content_of(folder_ / "run/run.h5");
  const std::string said = "--out run: holds the results of a run; --overwrite replaces them";
  refused(draw, {said});
  refused(draw + Words{"--shape", "M"}, {said});
  EXPECT_EQ(content_of(folder_ / "run/run.h5"), log);
  EXPECT_EQ(call(draw + Words{"--overwrite"}).code, 0);
  EXPECT_THAT(call(draw + Words{"--resume"}).err, Not(HasSubstr("--overwrite")));
  for (int i = 0; i < 2; ++i) EXPECT_EQ(call(Words{"draw"} + kShort).code, 0);
  ASSERT_EQ(call(Words{"compare", "--out", "both"} + kShort).code, 0);
  refused({"compare", "--out", "both"}, {"--out both/perception: holds", "--overwrite"});
  EXPECT_EQ(call(Words{"compare", "--out", "both", "--overwrite"} + kShort).code, 0);
}

// Lines of the file that a fill hides are in the picture, too.
TEST_F(CommandLine, HatchesAloneArePreviewedWhereLinesAreHidden) {
  write("a.svg", R"svg(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 60 60">
      <rect width="40" height="40"/><rect x="20" y="20" width="40" height="40" fill="#888"/>
      </svg>)svg");
  const Words hatches = {"--set", "drawing.hatch.spacing=2", "--set",
                         "drawing.hatch.outline=false"};
  for (const char* style : {"boustrophedon", "concentric", "contour-parallel"}) {
    const Ended ended = call(Words{"preview", "a.svg", "--out", std::string(style) + ".png"} +
                             hatches + Words{"--set", std::string("drawing.hatch.style=") + style});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("  hidden "));
    EXPECT_TRUE(std::filesystem::exists(folder_ / (std::string(style) + ".png")));
  }
  refused(Words{"preview", "a.svg", "--set", "drawing.hatch.style=concentric", "--set",
                "drawing.hatch.cross=true"} +
              hatches,
          {"cross is for style=boustrophedon"});
}

// Of a picture that a pen cannot draw, all three commands say so in the same words.
TEST_F(CommandLine, PlanDrawAndInspectTellTheSameOfAFile) {
  const std::vector<std::string> lost = {
      "1 × <image>: pictures are left out: only paths and shapes are read",
      "1 × <use> refers to '#gone', which the file does not hold: left out",
      "1 shapes are left out: hidden, or wholly transparent",
      "2.9 mm of lines are hidden by fills, wide strokes, clip paths, masks or the page's edge: "
      "left out",
      "1 shapes or groups are partly transparent: their lines are drawn as if they were not"};
  write("a.svg", R"svg(<svg xmlns="http://www.w3.org/2000/svg" width="120mm" height="120mm"
      viewBox="0 0 120 120"><image width="9" height="9" href="photo.png"/><use href="#gone"/>
      <clipPath id="c"><circle r="90"/></clipPath>
      <g fill="none" stroke="black"><circle cx="60" cy="60" r="60" opacity=".3"/>
      <path d="M60 50V70" clip-path="url(#c)"/>
      <path d="M9 9H99" style="display:none"/></g></svg>)svg");
  const Ended inspected = call({"inspect", "a.svg"});
  const Ended planned =
      call({"plan", "--svg", "a.svg", "--set", "drawing.placement.fit_radius=.1"});
  const Ended drawn = call(Words{"draw", "--svg", "a.svg"} + kShort);
  for (const std::string& words : lost) {
    EXPECT_THAT(inspected.out, HasSubstr("  warning      " + words + "\n"));
    EXPECT_THAT(planned.out, HasSubstr("  note: " + words + "\n"));
    EXPECT_THAT(drawn.err, HasSubstr("note: " + words + "\n"));
  }
  EXPECT_THAT(planned.out, Not(HasSubstr("all of it can be drawn")));
  EXPECT_THAT(planned.out,
              HasSubstr("  size     200 × 200 mm on the canvas, 1.67 × the file's 120 × 120 mm: "
                        "fitted to drawing.placement.fit_radius, 0.1 m; drawing.placement.scale=1 "
                        "keeps the file's size\n"));
  const nlohmann::json notes = json_of(folder_ / "runs/a-plan/plan.json").at("notes");
  EXPECT_EQ(notes, json_of(folder_ / "runs/a/strokes.json").at("notes"));
  ASSERT_GE(notes.size(), lost.size());
  const Words sized = {"plan", "--svg", "a.svg", "--set"};
  EXPECT_THAT(call(sized + Words{"drawing.placement.width=60"}).out,
              HasSubstr("  size     60 × 60 mm on the canvas, 0.5 × the file's 120 × 120 mm\n"));
  EXPECT_THAT(call(sized + Words{"drawing.placement.scale=1"}).out,
              HasSubstr("  size     120 × 120 mm on the canvas, as in the file\n"));
  EXPECT_THAT(call({"plan", "--shape", "circle"}).out, HasSubstr(" mm on the canvas\n"));
}

TEST_F(CommandLine, InspectSaysInOneLineWhatCannotBeRead) {
  const std::string meshes = ".obj, .stl, .ply, .off, .glb, .gltf, .3mf or .dae";
  fs::create_directory(folder_ / "folder");
  fs::create_directory(folder_ / "folder.svg");
  write("typo.yaml", "control: {normal_forc: 3}\n");
  for (const char* ending : {"svg", "csv", "strokes", "obj", "stl", "ply", "off", "glb", "yaml"}) {
    write(std::string("empty.") + ending, "");
    refused({"inspect", std::string("empty.") + ending}, {"the file is empty"});
    if (ending == std::string("yaml")) continue;
    write(std::string("garbage.") + ending, std::string("\x01\xfe\0\x80\xff\n\x7f", 7));
    refused({"inspect", std::string("garbage.") + ending}, {std::string("garbage.") + ending});
  }
  write("a.png", "x");
  refused({"inspect", "a.png"}, {"a.png: has the type '.png'", meshes, ".svg, .txt, .strokes"});
  refused({"inspect", "folder"}, {"folder: is a folder"});
  refused({"inspect", "folder.svg"}, {"folder.svg: is a folder"});
  refused({"inspect", "gone.glb"}, {"gone.glb: no such file"});
  refused({"inspect", "typo.yaml"}, {"./impedraw plan typo.yaml checks a scenario"});
  refused({"plan", "typo.yaml"}, {"typo.yaml:1: unknown key 'normal_forc'", "'normal_force'"});
}

// What is bad is named by the option that brought it, and nobody is told of a file that nobody
// named.
TEST_F(CommandLine, TheBadInputIsNamedAndNoOther) {
  write("ok.yaml", "name: ok\n");
  write("ok.svg", kLine);
  write("bad.obj", "x");
  const Words plan = {"plan", "ok.yaml", "--svg", "ok.svg", "--set", "canvas.kind=mesh", "--set"};
  refused(plan + Words{"canvas.mesh.file=bad.obj"}, {"--set canvas.mesh.file=bad.obj: "});
  refused(plan + Words{"canvas.mesh.file=gone.obj"}, {"--set canvas.mesh.file=gone.obj: "});
  refused({"plan", "ok.yaml", "--svg", "bad.obj"}, {"--svg bad.obj: "});
  refused({"plan", "ok.svg"}, {"ok.svg: is artwork, where a scenario", "--svg ok.svg"});
  refused({"draw", "--svg", "ok.svg", "--commissioned", "gone"}, {"--commissioned gone: "});
  for (const Words& arguments :
       {Words{"draw", "--set", "world.tip.friction=1", "--set", "control.wrench=none"},
        Words{"draw", "--svg", "ok.svg", "--set", "drawing.placement.scale=90"},
        Words{"draw", "--no-perception", "--set", "control.stiffness_normal=0"},
        Words{"draw", "--set", "drawing.placement.centre=[0.7, 0.1]"},
        Words{"draw", "--set", "path.turn_speed=5"}, Words{"draw", "--set", "name=.x"},
        Words{"draw", "--set", "arm.start=[0.1, 0.1, 0.1]"},
        Words{"draw", "--set", "canvas.cap.centre=[5, 0, 0]"},
        Words{"calibrate-tool", "--set", "control.wrench=none"},
        Words{"arm", "check", "--set", "arm.url=x"}}) {
    const Ended ended = call(arguments);
    SCOPED_TRACE(::testing::PrintToString(arguments));
    EXPECT_EQ(ended.code, 2);
    EXPECT_THAT(ended.err, Not(HasSubstr(".yaml")));
  }
}

TEST_F(CommandLine, WrongArguments) {
  refused({"drw"}, {"'drw'; did you mean 'draw'?"});
  refused({"draw", "--bogus"}, {"--bogus", "draw --help"});
  refused({"draw", "a.yaml", "b.yaml"}, {"b.yaml", "draw --help"});
  refused({"draw", "--shape", "M", "--svg", "x.svg"}, {"--shape excludes --svg"});
  refused({"draw", "--shape", ""}, {"--shape: a value is missing"});
  refused({"report"}, {"folder is required"});
  const Ended none = call({});
  EXPECT_EQ(none.code, 2);
  for (const char* command : {"draw", "compare", "report", "settings", "bench"})
    EXPECT_THAT(none.err, HasSubstr(command));
}

TEST_F(CommandLine, HelpHasExamples) {
  EXPECT_EQ(call({"--help"}).code, 0);
  for (const std::string command : {"draw", "compare", "report", "settings", "bench"}) {
    const Ended help = call({command, "--help"});
    EXPECT_EQ(help.code, 0) << command;
    EXPECT_THAT(help.out, AllOf(HasSubstr("Examples:"), HasSubstr("\n  ./impedraw " + command)))
        << command;
  }
}

TEST_F(CommandLine, SettingsPageIsTheProgramsOwn) {
  const Ended page = call({"settings", "--markdown"});
  EXPECT_EQ(page.code, 0);
  EXPECT_EQ(content_of(fs::path(IMPEDRAW_SOURCE) / "docs/settings.md"), page.out)
      << "write it anew: ./impedraw settings --markdown > docs/settings.md";
  EXPECT_THAT(call({"settings"}).out, HasSubstr("control.normal_force "));
}

TEST_F(CommandLine, ScenarioSchemaIsTheProgramsOwn) {
  const Ended schema = call({"settings", "--json-schema"});
  EXPECT_EQ(schema.code, 0);
  EXPECT_EQ(content_of(fs::path(IMPEDRAW_SOURCE) / "docs/scenario.schema.json"), schema.out)
      << "write it anew: ./impedraw settings --json-schema > docs/scenario.schema.json";
}

TEST_F(CommandLine, FormerNamesAreReadAndToldOnce) {
  write("old.yaml", "name: old\ncontrol:\n  push: 4\n  wrench: true\n");
  const Words plan = {"plan", "old.yaml", "--set", "preflight.arm=false", "--out", "plan"};
  const Ended old = call(plan + Words{"--set", "control.push=3"});
  EXPECT_EQ(old.code, 0);
  EXPECT_EQ(old.err,
            "impedraw: old.yaml:3: control.push is now called control.normal_force\n"
            "impedraw: old.yaml:4: control.wrench: true is now called ground_truth\n");
  const Ended now = call({"plan", "--set", "preflight.arm=false", "--out", "plan", "--set",
                          "control.normal_force=3", "--set", "control.wrench=ground_truth"});
  EXPECT_THAT(now.err, IsEmpty());
}

TEST_F(CommandLine, DrawsIntoRunsBesideTheUserAndReportsAgain) {
  const Ended first = call(Words{"draw"} + kShort);
  EXPECT_EQ(first.code, 0);
  EXPECT_THAT(first.err, IsEmpty()) << "progress is for terminals";
  const fs::path run = folder_ / "runs/bowl-sine";
  EXPECT_THAT(first.out, HasSubstr((run / "report.html").string()));
  const std::string metrics = content_of(run / "metrics.json"), log = content_of(run / "run.h5");
  EXPECT_EQ(json_of(run / "metrics.json").at("strokes_missed"), 0);

  fs::remove(run / "metrics.json");
  fs::remove(run / "report.html");
  EXPECT_EQ(call({"report", "runs/bowl-sine"}).code, 0);
  EXPECT_EQ(content_of(run / "metrics.json"), metrics);
  EXPECT_TRUE(fs::exists(run / "report.html"));
  EXPECT_EQ(content_of(run / "run.h5"), log);

  // Its own resolved scenario draws the same again, over the run that is there.
  const Words again = {"draw", "runs/bowl-sine/scenario.yaml", "--out", "runs/bowl-sine"};
  EXPECT_EQ(call(again + Words{"--overwrite"}).code, 0);
  const auto was = nlohmann::json::parse(metrics), is = json_of(run / "metrics.json");
  EXPECT_EQ(is.at("ink_error_rms"), was.at("ink_error_rms"));
}

TEST_F(CommandLine, AReducedLogGivesTheSameMetricsAndReportKeepsThem) {
  for (const std::string rate : {"full", "reduced"})
    EXPECT_EQ(call(Words{"draw", "--out", rate, "--set", "log.rate=" + rate} + kShort).code, 0);
  auto full = json_of(folder_ / "full/metrics.json"),
       reduced = json_of(folder_ / "reduced/metrics.json");
  for (const char* wall :
       {"step_time_p50", "step_time_p99", "step_time_p999", "real_time_factor", "wall_seconds"})
    full.erase(wall), reduced.erase(wall);
  EXPECT_EQ(full.dump(), reduced.dump());
  EXPECT_LT(fs::file_size(folder_ / "reduced/run.h5"), fs::file_size(folder_ / "full/run.h5") / 2)
      << "most of so short a run's is the canvas";
  const std::string metrics = content_of(folder_ / "reduced/metrics.json");
  EXPECT_EQ(call({"report", "reduced"}).code, 0);
  EXPECT_EQ(content_of(folder_ / "reduced/metrics.json"), metrics);
}

TEST_F(CommandLine, ComparesBothWays) {
  const Ended ended = call(Words{"compare", "--out", "both"} + kShort);
  EXPECT_EQ(ended.code, 0) << ended.err;
  for (const char* file : {"compare.html", "compare.png", "perception/run.h5",
                           "perception/metrics.json", "blind/run.h5", "blind/metrics.json"})
    EXPECT_GT(fs::file_size(folder_ / "both" / file), 100u) << file;
  EXPECT_LT(json_of(folder_ / "both/perception/metrics.json").at("tilt_mean").get<double>(), 2.0);
  EXPECT_GT(json_of(folder_ / "both/blind/metrics.json").at("tilt_mean").get<double>(), 5.0);
}

TEST_F(CommandLine, TheSameSeedGivesTheSameNumbers) {
  const Words noise = kShort + Words{"--set", "perception.noise.sigma_at_1m=0.001"};
  const auto draw = [&](const std::string& out, const Words& more) {
    EXPECT_EQ(call(Words{"draw", "--out", out} + more).code, 0) << out;
  };
  draw("a", kShort);
  draw("b", kShort);
  draw("noisy_a", noise);
  draw("noisy_b", noise);
  draw("other", noise + Words{"--set", "seed=2"});
  const Ended compared = python(R"(
import h5py, os
def datasets(name):
    found = {}
    with h5py.File(os.path.join(os.path.dirname(__file__), name, 'run.h5')) as f:
        f.visititems(lambda key, item: found.update({key: item[()].tobytes()})
                     if isinstance(item, h5py.Dataset) else None)
    return found
def different(a, b):
    a, b = datasets(a), datasets(b)
    assert len(a) > 25 and a.keys() == b.keys()
    return sorted(key for key in a if a[key] != b[key])
print(set(different('a', 'b')) - {'controller/step_time'} or 'same',
      set(different('noisy_a', 'noisy_b')) - {'controller/step_time'} or 'same')
print('cloud/points' in different('noisy_a', 'other'),
      'tip/position' in different('noisy_a', 'other'),
      'tip/position' in different('a', 'noisy_a'))
)");
  EXPECT_EQ(compared.out, "same same\nTrue True True\n");
}

// 200 N on the pen, and gravity ten times what the controller knows: both beyond what the arm can
// hold.
TEST_F(CommandLine, AnUnstableRunStopsAndKeepsItsLog) {
  for (const char* cause : {"pushes=[{force: 200, direction: [0, 0, 1], middle: 0.5, duration: 3}]",
                            "world.gravity=100"}) {
    SCOPED_TRACE(cause);
    const Ended ended = call(Words{"draw", "--out", "run", "--set", cause} + kShort);
    EXPECT_EQ(ended.code, 3);
    std::smatch when;
    ASSERT_TRUE(std::regex_search(
        ended.err, when,
        std::regex(
            "(?:unstable|above its speed limit of [0-9.]+ rad/s|the fence is 150.0 N) at t = "
            "([0-9.]+) s")))
        << ended.err;
    EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1);
    const RunData run = read_run(folder_ / "run/run.h5");
    // The pen may have been lifted since.
    EXPECT_GT(run.time.back(), std::stod(when[1]) - 2e-3);
    EXPECT_LT(run.time.back(), std::stod(when[1]) + 5.0);
    const auto metrics = json_of(folder_ / "run/metrics.json");
    EXPECT_EQ(metrics.at("ending").at("end"), "stopped");
    EXPECT_EQ(metrics.at("ending").at("incident"), "incident.html");
    EXPECT_THAT(ended.out, HasSubstr((folder_ / "run/incident.html").string()));
    EXPECT_TRUE(metrics.contains("contact_fraction"));
    EXPECT_TRUE(fs::exists(folder_ / "run/report.html"));
  }
}

// The arm sags less than the stiffness control believes: the pen never comes down.
TEST_F(CommandLine, NothingDrawnIsAFailureWithItsReason) {
  const Ended ended = call({"draw", (fs::path(IMPEDRAW_SOURCE) / "scenarios/bowl-sine-blind.yaml"),
                            "--set", "world.gravity=8.455", "--out", "run"});
  EXPECT_EQ(ended.code, 3);
  EXPECT_THAT(ended.err, AllOf(HasSubstr("nothing drawn: "), HasSubstr("never pressed")));
  EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1);
  EXPECT_THAT(ended.out, HasSubstr(", 0 %; the rest: no ink "));
  EXPECT_THAT(ended.out, Not(HasSubstr("tilt_mean"))) << "the full table is for --metrics";
  const auto ending = json_of(folder_ / "run/metrics.json").at("ending");
  EXPECT_EQ(ending.at("end"), "nothing_drawn");
  EXPECT_FALSE(ending.contains("incident"));
  EXPECT_THAT(call({"report", "run", "--metrics"}).out,
              AllOf(HasSubstr("nothing drawn: "), HasSubstr("tilt_mean")));
}

TEST_F(CommandLine, InterruptKeepsWhatIsDrawn) {
  for (const bool draws : {false, true}) {
    SCOPED_TRACE(draws);
    fs::remove_all(folder_ / "run");
    Process process(folder_, Words{"draw", "--out", "run"} + kLong);
    draws ? until_drawing(process) : until_running(process);
    process.signal(SIGINT);
    const Ended ended = process.wait();
    EXPECT_EQ(ended.code, 130);
    EXPECT_THAT(ended.err, AllOf(HasSubstr("interrupted at t = "), HasSubstr("log is kept")));
    const RunData run = read_run(folder_ / "run/run.h5");
    ASSERT_GT(run.rows(), 0u);
    EXPECT_LT(run.time.back(), 150.0);
    const auto metrics = json_of(folder_ / "run/metrics.json");
    EXPECT_THAT(ended.out, HasSubstr("stopped by a person: interrupted at t = "));
    EXPECT_EQ(metrics.at("ending").at("end"), "interrupted");
    EXPECT_GT(metrics.at("not_drawn_mm").at("not_reached").get<double>(), 1.0);
    if (draws)
      EXPECT_EQ(metrics.at("contact_fraction").get<double>(), 1.0);
    else
      EXPECT_TRUE(metrics.at("contact_fraction").is_null() ||
                  metrics.at("contact_fraction") == 1.0);
    EXPECT_TRUE(fs::exists(folder_ / "run/report.html"));
  }
}

// A program at a pseudo-terminal, and what it shows there.
struct Terminal {
  pid_t pid = -1;
  int end = -1;
  std::string shown;

  Terminal(const fs::path& folder, const Words& arguments) {
    winsize size{24, 100, 0, 0};
    pid = forkpty(&end, nullptr, nullptr, &size);
    if (pid == 0) Process::start(folder, arguments);
  }
  ~Terminal() { close(end); }
  bool read() {
    char text[4096];
    const ssize_t n = ::read(end, text, sizeof text);
    if (n > 0) shown.append(text, static_cast<std::size_t>(n));
    return n > 0;
  }
  int wait() {
    int status = 0;
    waitpid(pid, &status, 0);
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  }
};

TEST_F(CommandLine, ATerminalShowsProgress) {
  Terminal terminal(folder_, Words{"draw", "--out", "run", "--set", "path.draw_speed=0.002"});
  while (terminal.read()) {
  }
  EXPECT_EQ(terminal.wait(), 0);
  EXPECT_TRUE(std::regex_search(
      terminal.shown,
      std::regex(
          R"(drawing +[0-9.]+ s  stroke 1/1  [0-9.]+/[0-9.]+ m +[0-9]+ %  [0-9]+:[0-9]+ left)")))
      << terminal.shown;
  EXPECT_THAT(terminal.shown, HasSubstr("\r\x1b[K")) << "the line goes when the run is over";
}

TEST_F(CommandLine, AKilledRunLosesAboutASecond) {
  Terminal terminal(folder_, Words{"draw", "--out", "run"} + kLong);
  const auto begun = [&] { return terminal.shown.find("real time") != std::string::npos; };
  while (!begun() && terminal.read()) {
  }
  const auto start = Clock::now();
  while (Clock::now() - start < std::chrono::milliseconds(2500) && terminal.read()) {
  }
  kill(terminal.pid, SIGKILL);
  ASSERT_EQ(terminal.wait(), 137) << terminal.shown;
  const std::regex line(R"(drawing +([0-9.]+) s [^\r]* ([0-9]+)x real time)");
  std::smatch last;
  for (std::sregex_iterator at(terminal.shown.begin(), terminal.shown.end(), line), none;
       at != none; ++at)
    last = *at;
  ASSERT_FALSE(last.empty()) << terminal.shown;
  EXPECT_EQ(read_run(folder_ / "run/run.h5").rows(), 0u) << "the log is as the run began";
  EXPECT_EQ(call({"report", "run"}).code, 0);
  const RunData run = read_run(folder_ / "run/run.h5");
  ASSERT_GT(run.rows(), 1000u);
  const double kept = run.time.back(), shown = std::stod(last[1]),
               per_wall_second = std::stod(last[2]);
  EXPECT_GT(kept, shown - 1.5 * per_wall_second)
      << "of " << shown << " s simulated, at " << per_wall_second << " times real time";
  EXPECT_TRUE(json_of(folder_ / "run/metrics.json").at("ink_error_rms").is_number());
}

// As on a full disk: the file that reaches its limit cannot grow.
TEST_F(CommandLine, ALogThatCannotBeWrittenIsSaid) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{1 << 20, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const Ended ended = call(Words{"draw", "--out", "run"} + kShort);
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(ended.code, 3);
  EXPECT_THAT(ended.err, AllOf(HasSubstr("cannot write run/run.h5"), HasSubstr("File too large")));
  EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
}

}  // namespace
}  // namespace impedraw

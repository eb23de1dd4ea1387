// The library as its users meet it: installed, moved elsewhere, found by CMake, and the examples
// built on it outside of the tree.
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include <gmock/gmock.h>

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

struct Ended {
  int code;
  std::string out;  // and err
};

Ended run(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return {127, "popen failed"};
  std::string out;
  std::array<char, 4096> buffer;
  while (const std::size_t read = fread(buffer.data(), 1, buffer.size(), pipe))
    out.append(buffer.data(), read);
  const int status = pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128, out};
}

std::string quoted(const fs::path& path) { return "'" + path.string() + "'"; }

class InstalledLibrary : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("impedraw-examples-" + std::to_string(getpid()));
    fs::create_directories(folder_);
    installed_ =
        run(std::string("'" CMAKE "' --install '" BUILD "' --component library --prefix ") +
            quoted(folder_ / "first"));
    if (installed_.code != 0) return;
    fs::rename(folder_ / "first", folder_ / "prefix");
    fs::copy(SOURCE "/examples", folder_ / "examples", fs::copy_options::recursive);
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  void SetUp() override { ASSERT_EQ(installed_.code, 0) << installed_.out; }

  // Pinocchio and {fmt} for the component `arm`, from where this build has them.
  static inline const std::string kPinocchio = " -DCMAKE_PREFIX_PATH='" PINOCCHIO_PREFIX "'";

  static std::string configure(const fs::path& source, const fs::path& build) {
    return "'" CMAKE "' -G '" GENERATOR "' -DCMAKE_MAKE_PROGRAM='" MAKE_PROGRAM
           "' -DCMAKE_CXX_COMPILER='" CXX "' -DEigen3_DIR='" EIGEN_DIR "' -S " +
           quoted(source) + " -B " + quoted(build);
  }
  // -O1: the examples need not be fast. One after the other: ctest has more to run.
  static Ended build(const std::string& example, const std::string& flags = "",
                     const std::string& more = "") {
    const fs::path out = folder_ / ("build" + flags) / example;
    return run(configure(folder_ / "examples" / example, out) + " -Dimpedraw_DIR=" +
               quoted(folder_ / "prefix/lib/cmake/impedraw") + more + " -DCMAKE_CXX_FLAGS='" +
               flags + "' -DCMAKE_CXX_FLAGS_RELEASE='-O1 -DNDEBUG' && '" CMAKE "' --build " +
               quoted(out) + " --parallel 1");
  }

  static fs::path folder_;
  static Ended installed_;
};

fs::path InstalledLibrary::folder_;
Ended InstalledLibrary::installed_{};

TEST_F(InstalledLibrary, ItsHeadersIncludeEachOtherEigenAndTheStandardLibrary) {
  const fs::path include = folder_ / "prefix/include/impedraw";
  const std::regex own("#include \"impedraw/(.*)\""), eigen("#include <Eigen/\\w+>"),
      standard("#include <[a-z_]+>");
  int headers = 0;
  for (const auto& entry : fs::recursive_directory_iterator(include)) {
    if (!entry.is_regular_file()) continue;
    ++headers;
    std::ifstream in(entry.path());
    std::smatch match;
    for (std::string line; std::getline(in, line);) {
      if (!line.starts_with("#include")) continue;
      const bool known = std::regex_match(line, match, own)
                             ? fs::exists(include / match[1].str())
                             : std::regex_match(line, eigen) || std::regex_match(line, standard);
      EXPECT_TRUE(known) << entry.path() << ": " << line;
    }
  }
  EXPECT_GE(headers, 40);
  // Of the folders in part: what they leave behind needs Rust, Embree or Pinocchio's headers.
  EXPECT_TRUE(fs::exists(include / "planning/path/tip_planner.h"));
  EXPECT_TRUE(fs::exists(include / "drawing/placement.h"));
  for (const char* header :
       {"drawing/svg.h", "planning/preflight", "planning/wrap", "canvas", "arm/urdf_model.h"})
    EXPECT_FALSE(fs::exists(include / header)) << header;
}

// By hand, without CMake and pkg-config.
TEST_F(InstalledLibrary, AnotherArchitectureThanTheLibrarysDoesNotCompile) {
  const fs::path program = folder_ / "by_hand.cc";
  std::ofstream(program) << "#include \"impedraw/control/impedance.h\"\n";
  const fs::path eigen = fs::path(EIGEN_DIR) / "../../../include/eigen3";
  const std::string compile = "'" CXX "' -std=c++20 -fsyntax-only -I" +
                              quoted(folder_ / "prefix/include") + " -I" + quoted(eigen) + " " +
                              quoted(program);
  const Ended alike = run(compile);
  EXPECT_EQ(alike.code, 0) << alike.out;
  const Ended other = run(compile + " -mavx512f");
  EXPECT_NE(other.code, 0);
  EXPECT_THAT(other.out, HasSubstr("libimpedraw was built for Eigen's alignment of 16 bytes"));
}

// A copy can be given to another machine: neither CMake's files nor the archives name a folder of
// the build, of the source or of the venv.
TEST_F(InstalledLibrary, ItNamesNoFolderOfTheMachineThatBuiltIt) {
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "prefix")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    for (const std::string folder : {SOURCE, BUILD, PINOCCHIO_PREFIX})
      EXPECT_EQ(text.find(folder), std::string::npos) << entry.path() << " names " << folder;
  }
  EXPECT_GE(files, 50);
}

// What is not asked for is not looked for: only `arm` needs Pinocchio.
TEST_F(InstalledLibrary, AComponentBringsItsOwnNeedsAlone) {
  const fs::path source = folder_ / "components";
  fs::create_directories(source);
  const auto configured = [&](const std::string& components, const std::string& more = "") {
    std::ofstream(source / "CMakeLists.txt")
        << "cmake_minimum_required(VERSION 3.16)\nproject(components CXX)\n"
        << "find_package(impedraw 0.1 REQUIRED " << components << ")\n"
        << "foreach(name control sensing perception planning strokes arm)\n"
        << "  if(TARGET impedraw::${name})\n    message(STATUS \"has ${name}.\")\n  endif()\n"
        << "endforeach()\nmessage(STATUS \"fmt ${fmt_FOUND}, arm ${impedraw_arm_FOUND}.\")\n";
    const fs::path out = folder_ / "build/components";
    fs::remove_all(out);
    return run(configure(source, out) +
               " -Dimpedraw_DIR=" + quoted(folder_ / "prefix/lib/cmake/impedraw") + more);
  };
  const std::string bare = " -DCMAKE_DISABLE_FIND_PACKAGE_pinocchio=ON";

  const Ended none = configured("", bare);
  EXPECT_EQ(none.code, 0) << none.out;
  EXPECT_THAT(none.out, AllOf(HasSubstr("has control."), HasSubstr("has sensing.")));
  EXPECT_THAT(none.out, Not(HasSubstr("has planning.")));
  EXPECT_THAT(none.out, HasSubstr("fmt ,"));

  const Ended two = configured("COMPONENTS perception planning", bare);
  EXPECT_EQ(two.code, 0) << two.out;
  EXPECT_THAT(two.out, AllOf(HasSubstr("has perception."), HasSubstr("has planning."),
                             HasSubstr("has strokes."), HasSubstr("has control.")));
  EXPECT_THAT(two.out, Not(HasSubstr("has arm.")));

  const Ended arm = configured("COMPONENTS arm", bare);
  EXPECT_NE(arm.code, 0);
  EXPECT_THAT(arm.out, HasSubstr("pinocchio"));
  const Ended maybe = configured("COMPONENTS control OPTIONAL_COMPONENTS arm", bare);
  EXPECT_EQ(maybe.code, 0) << maybe.out;
  EXPECT_THAT(maybe.out, AllOf(Not(HasSubstr("has arm.")), HasSubstr("arm FALSE.")));
  const Ended found = configured("COMPONENTS arm", kPinocchio);
  EXPECT_EQ(found.code, 0) << found.out;
  EXPECT_THAT(found.out, HasSubstr("has arm."));

  const Ended unknown = configured("COMPONENTS control planing");
  EXPECT_NE(unknown.code, 0);
  EXPECT_THAT(unknown.out, HasSubstr("no component 'planing'"));
}

TEST_F(InstalledLibrary, TheControllerAloneNamesWhatItsTorqueIsMadeOf) {
  const Ended built = build("01_controller");
  ASSERT_EQ(built.code, 0) << built.out;
  EXPECT_THAT(built.out, Not(HasSubstr("warning")));
  const Ended ended = run(quoted(folder_ / "build/01_controller/controller"));
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.out, StartsWith("contact, all well: yes\n"));

  // One row the torque, one each term: they add up. The surface carries the push, so push and
  // wrench leave −Jᵀ F_ext: 0.6 m · 5 N.
  std::istringstream out(ended.out);
  std::vector<std::array<double, 7>> rows;
  std::vector<std::string> names;
  for (std::string line; std::getline(out, line);) {
    if (names.empty() && !line.starts_with("torque [Nm]")) continue;
    names.push_back(line.substr(0, 18));
    std::istringstream numbers(line.substr(18));
    rows.emplace_back();
    for (double& x : rows.back()) ASSERT_TRUE(numbers >> x) << line;
  }
  ASSERT_EQ(rows.size(), 9u) << ended.out;
  for (int j = 0; j < 7; ++j) {
    double sum = 0.0;
    for (std::size_t i = 1; i < rows.size(); ++i) sum += rows[i][j];
    EXPECT_NEAR(sum, rows[0][j], 0.005);
  }
  EXPECT_THAT(names[3], HasSubstr("push"));
  EXPECT_THAT(names[4], HasSubstr("wrench"));
  EXPECT_NEAR(rows[3][1] + rows[4][1], 0.6 * 5.0, 0.002);
}

TEST_F(InstalledLibrary, ASimulatorOfOnesOwnKeepsForceAndLine) {
  const Ended built = build("02_own_simulator");
  ASSERT_EQ(built.code, 0) << built.out;
  EXPECT_THAT(built.out, Not(HasSubstr("warning")));
  const std::string program = quoted(folder_ / "build/02_own_simulator/own_simulator");
  const Ended good = run(program), rough = run(program + " 0.9");
  EXPECT_EQ(good.code, 0) << good.out;
  EXPECT_EQ(rough.code, 1)
      << "three times the friction believed takes the line out of its tolerance\n"
      << rough.out;
  EXPECT_THAT(rough.out, HasSubstr("out of tolerance"));
}

TEST_F(InstalledLibrary, FromACloudToNormalsToATimedPathToTorque) {
  const Ended built = build("03_own_surface", "", kPinocchio);
  ASSERT_EQ(built.code, 0) << built.out;
  EXPECT_THAT(built.out, Not(HasSubstr("warning:")));
  const std::string program =
      quoted(folder_ / "build/03_own_surface/own_surface") + " '" SOURCE "/models/iiwa14_pen.urdf'";
  const Ended good = run(program), rough = run(program + " 2"), lost = run(program + " 4");
  EXPECT_EQ(good.code, 0) << good.out;
  EXPECT_EQ(rough.code, 1) << rough.out;
  EXPECT_THAT(rough.out, HasSubstr("out of tolerance"));
  EXPECT_EQ(lost.code, 2) << lost.out;
  EXPECT_THAT(lost.out, HasSubstr("stroke 0 leaves the canvas"));
}

TEST_F(InstalledLibrary, ItIsNotLinkedWhereEigenWouldLayOutItsTypesOtherwise) {
#if !defined(__x86_64__) || defined(__AVX__)
  GTEST_SKIP() << "needs a library for x86-64 without AVX";
#endif
  const Ended built = build("01_controller", "-mavx");
  EXPECT_NE(built.code, 0);
  EXPECT_THAT(built.out, HasSubstr("libimpedraw was built for Eigen's alignment of 16 bytes"));
}

TEST_F(InstalledLibrary, OnItsOwnItNeedsEigenAlone) {
  const Ended configured = run(configure(SOURCE, folder_ / "library") +
                               " -DIMPEDRAW_LIBRARY_ONLY=ON -DIMPEDRAW_VENV=/nowhere");
  EXPECT_EQ(configured.code, 0) << configured.out;
  const Ended steps = run("'" CMAKE "' --build " + quoted(folder_ / "library") + " -- -n");
  EXPECT_THAT(steps.out, HasSubstr("libimpedraw_sensing.a"));
  EXPECT_THAT(steps.out, Not(HasSubstr("arm_model")));
}

TEST_F(InstalledLibrary, PlanningAndPerceptionNeedNeitherRustNorTheVenv) {
  const Ended configured =
      run(configure(SOURCE, folder_ / "planning") +
          " -DIMPEDRAW_LIBRARY_ONLY=ON -DIMPEDRAW_COMPONENTS='perception;planning' "
          "-DIMPEDRAW_VENV=/nowhere -DCARGO=/nowhere -DCMAKE_DISABLE_FIND_PACKAGE_PkgConfig=ON");
  EXPECT_EQ(configured.code, 0) << configured.out;
  const Ended steps = run("'" CMAKE "' --build " + quoted(folder_ / "planning") + " -- -n");
  EXPECT_THAT(steps.out,
              AllOf(HasSubstr("libimpedraw_planning.a"), HasSubstr("libimpedraw_perception.a"),
                    HasSubstr("libimpedraw_strokes.a")));
  for (const char* left_out : {"cargo", "arm_model", "svg.cc", "preflight", "wrap"})
    EXPECT_THAT(steps.out, Not(HasSubstr(left_out)));
  const Ended unknown = run(configure(SOURCE, folder_ / "unknown") +
                            " -DIMPEDRAW_LIBRARY_ONLY=ON -DIMPEDRAW_COMPONENTS=path");
  EXPECT_NE(unknown.code, 0);
  EXPECT_THAT(unknown.out, HasSubstr("there is no 'path'; valid are control"));
}

TEST_F(InstalledLibrary, CMakeRefusesAnIncludeThatRunsUpwards) {
  const fs::path tree = folder_ / "tree";
  for (const char* part : {"CMakeLists.txt", "LICENSE", "cmake", "src"}) {
    fs::create_directories(tree);
    fs::copy(fs::path(SOURCE) / part, tree / part, fs::copy_options::recursive);
  }
  const auto configured = [&] {
    return run(configure(tree, folder_ / "layers") +
               " -DIMPEDRAW_LIBRARY_ONLY=ON -DIMPEDRAW_COMPONENTS='perception;planning'");
  };
  const Ended good = configured();
  EXPECT_EQ(good.code, 0) << good.out;
  std::ofstream(tree / "src/control/damping.h", std::ios::app)
      << "#include \"impedraw/planning/path/tip_path.h\"\n";
  const Ended upwards = configured();
  EXPECT_NE(upwards.code, 0);
  EXPECT_THAT(upwards.out, HasSubstr("src/control/damping.h includes planning/path/tip_path.h"));
}

}  // namespace
}  // namespace impedraw

// The program among hostile names, texts and surroundings: refused before anything is drawn, and
// nothing that moves the cursor reaches the terminal.
#include <sys/stat.h>

#include <gmock/gmock.h>

#include "iiwa_variants.h"
#include "process.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using Words = std::vector<std::string>;

const char* const kLine =
    R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">
    <path d="M5 5H15" fill="none" stroke="black"/></svg>)";
const std::string kEscape = "\x1b]0;mine\x07\x1b[2J";

bool has_control(const std::string& text) {
  if (text.find("\xc2\x9b") != std::string::npos) return true;
  return std::any_of(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) < 0x20 && c != '\n') || c == 0x7f;
  });
}

class SurroundingsTest : public ScratchFolder {
 protected:
  Ended call(const Words& arguments) const { return Process(folder_, arguments).wait(); }
  // `command` of a shell in which $P is the program.
  Ended shell(const std::string& command) const {
    const fs::path script =
        write("script.sh", "P=" IMPEDRAW "\ncd " + folder_.string() + "\n" + command + "\n");
    const int status =
        std::system(("bash " + script.string() + " >" + (folder_ / ".stdout").string() + " 2>" +
                     (folder_ / ".stderr").string())
                        .c_str());
    return {WEXITSTATUS(status), content_of(folder_ / ".stdout"), content_of(folder_ / ".stderr")};
  }
  void refused(const Ended& ended, const std::string& said) const {
    EXPECT_EQ(ended.code, 2) << ended.err;
    EXPECT_THAT(ended.out, IsEmpty());
    EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
    EXPECT_FALSE(has_control(ended.err)) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(said));
    EXPECT_FALSE(fs::exists(folder_ / "runs"));
  }
};

TEST_F(SurroundingsTest, NamesThatAreNotUtf8) {
  write("x.svg", kLine);
  const std::string bytes = "na\xffme";
  for (const Words& arguments :
       {Words{"draw", "--set", "name=" + bytes}, Words{"draw", "--out", bytes},
        Words{"draw", "--svg", bytes + ".svg"}, Words{"plan", bytes + ".yaml"},
        Words{"draw", "--text", bytes}, Words{"report", bytes}, Words{"inspect", bytes}})
    refused(call(arguments), "not valid UTF-8");
  write("x.yaml", "name: " + bytes + "\n");
  refused(call({"plan", "x.yaml"}), "x.yaml: is not UTF-8");
  fs::create_directories(folder_ / bytes);
  refused(shell("cd $'na\\xffme' && $P draw"), "working directory");
}

TEST_F(SurroundingsTest, NamesThatAreTooLong) {
  const std::string name(300, 'x');
  for (const Words& arguments :
       {Words{"draw", "--set", "name=" + name}, Words{"plan", "--out", name},
        Words{"draw", "--svg", name + ".svg"}, Words{"plan", name + ".yaml"}, Words{"report", name},
        Words{"inspect", name + ".svg"}, Words{"inspect", name + ".stl"},
        Words{"plan", "--set", "arm.urdf=" + name}})
    refused(call(arguments), "");
}

TEST_F(SurroundingsTest, ControlCharactersStayOutOfTheTerminal) {
  refused(call({"plan", "--set", kEscape + "=1"}), "unknown key");
  refused(call({"plan", "--set", "name=a" + kEscape}), "name is");
  refused(call({"plan", "--set", "name=a\nb"}), "name is");
  refused(call({"plan", kEscape + ".yaml"}), "no such file");
  refused(call({kEscape}), "command");
  refused(call({"draw", "--" + kEscape}), "");
  refused(call({"plan", "--svg", kEscape + ".svg"}), "");
  write("keys.yaml", "\"\\e[2J\\x9b5m\": 1\n");
  refused(call({"plan", "keys.yaml"}), "unknown key");
  write("value.yaml", "drawing: {shape: \"\\e[2J\\u202E\"}\n");
  const Ended value = call({"plan", "value.yaml"});
  refused(value, "drawing.shape is");
  EXPECT_THAT(value.err, Not(HasSubstr("\u202E")));
  write("arm.urdf", changed(iiwa_urdf(), "<joint name=\"joint_3\"", "joint_3\" type=\"revolute\"",
                            "\u009b2J\" type=\"planar\""));
  refused(call({"plan", "--set", "arm.urdf=arm.urdf"}), "is planar");
  write("layers.txt", "layer a" + kEscape + "\n0 0\n10 0\n");
  write("shape.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 " + kEscape + "\n");
  for (const std::string file : {"layers.txt", "shape.obj"}) {
    const Ended inspected = call({"inspect", file});
    EXPECT_FALSE(has_control(inspected.out + inspected.err)) << inspected.out << inspected.err;
  }
}

TEST_F(SurroundingsTest, AGivenNameCountsBesideArtwork) {
  write("line.svg", kLine);
  const Ended ended = call({"plan", "--svg", "line.svg", "--set", "name=mine"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(fs::exists(folder_ / "runs/mine-plan/plan.json"));
}

TEST_F(SurroundingsTest, AFullStandardOutputIsAnError) {
  write("line.svg", kLine);
  for (const std::string command :
       {"$P settings", "$P inspect line.svg", "$P plan --svg line.svg --json"}) {
    const Ended ended = shell(command + " >/dev/full");
    EXPECT_EQ(ended.code, 3) << command;
    EXPECT_THAT(ended.err, HasSubstr("standard output")) << command;
  }
  EXPECT_EQ(shell("$P settings --json-schema >&-").code, 0);
}

// Latin-1 where localedef can make it, a matplotlibrc that cannot be read, a home that must stay
// empty, and SIGCHLD ignored.
TEST_F(SurroundingsTest, ADrawingDoesNotDependOnThem) {
  write("line.svg", kLine);
  write("matplotlibrc", "svg.fonttype: \xff\n");
  fs::create_directories(folder_ / "home");
  const Ended ended = shell(
      "localedef -i en_US -f ISO-8859-1 ./en_US.l1 2>/dev/null\n"
      "trap '' CHLD\n"
      "env LOCPATH=$PWD LC_ALL=en_US.l1 HOME=$PWD/home XDG_CACHE_HOME= XDG_CONFIG_HOME= "
      "$P draw --svg line.svg --set name=Größe");
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.err, IsEmpty());
  EXPECT_THAT(content_of(folder_ / "runs/Größe/report.html"), HasSubstr("Größe"));
  EXPECT_TRUE(fs::is_empty(folder_ / "home"));
}

}  // namespace
}  // namespace impedraw

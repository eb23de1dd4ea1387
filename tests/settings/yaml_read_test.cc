#include "impedraw/settings/yaml_read.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "example_settings.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/settings/yaml_write.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using example::Scenario;
using example::Sensor;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

Scenario from_text(const std::string& yaml, Scenario scenario = {}) {
  Places places;
  read_yaml_text(yaml, "s.yaml", "", described(scenario), places);
  return scenario;
}

Scenario with(const std::vector<std::string>& assignments) {
  Scenario scenario;
  read_settings(scenario, "", assignments);
  return scenario;
}

// The message of the InputError that f throws, which must be one line.
template <class F>
std::string error_of(F f) {
  try {
    f();
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), Not(HasSubstr("\n")));
    return e.what();
  }
  ADD_FAILURE() << "no InputError";
  return "";
}
std::string yaml_error(const std::string& yaml) {
  return error_of([&] { from_text(yaml); });
}
std::string set_error(const std::string& assignment) {
  return error_of([&] { with({assignment}); });
}

struct Sides {
  bool both = true;
  int count = 2;
  Eigen::Vector2d along{0.5, 1.0};
};

template <class F>
void describe(F& f, Sides& s) {
  f.constant("along", s.along, {0.0, 1.0}, "m");
  f.constant("both", s.both, Range::any(), "");
  f.constant("count", s.count, {1, 4}, "");
}

struct Fold {
  double height = 0.002;
  double width = 1.0;
  std::optional<double> depth;
  std::vector<double> steps{0.1, 0.2};
  Sides sides;
};

template <class F>
void describe(F& f, Fold& s) {
  f.constant("height", s.height, {0.0, 1.0}, "m");
  f.field("width", s.width, {0.0, 1.0}, "m", "width of the fold").for_users().formerly("size");
  f.field("depth", s.depth, Range::positive_to(0.5), "m", "depth of the fold");
  f.field("steps", s.steps, {0.0, 1.0}, "m", "its steps");
  f.field("sides", s.sides, "its sides");
}

// The library's check of ranges reads the description that the scenario's reader reads.
TEST(Description, GivesTheRangesOfTheLibrarysCheck) {
  const auto refusal = [](auto change) {
    Fold fold;
    change(fold);
    return error_of([&] { require_ranges("fold", fold); });
  };
  EXPECT_NO_THROW(require_ranges("fold", Fold()));
  EXPECT_EQ(refusal([](Fold& f) { f.height = 2.0; }), "fold.height is 2 m, allowed is 0 to 1 m");
  EXPECT_EQ(refusal([](Fold& f) { f.width = -1.0; }), "fold.width is -1 m, allowed is 0 to 1 m");
  EXPECT_EQ(refusal([](Fold& f) { f.depth = 0.0; }),
            "fold.depth is 0 m, allowed is more than 0 and at most 0.5 m");
  EXPECT_EQ(refusal([](Fold& f) { f.steps[1] = std::nan(""); }),
            "fold.steps is nan m, allowed is 0 to 1 m");
  EXPECT_EQ(refusal([](Fold& f) { f.sides.count = 5; }),
            "fold.sides.count is 5, allowed is 1 to 4");
}

// A group of constants alone is read and refused like others, and is not written.
TEST(Description, AGroupOfConstantsIsReadAndNotWritten) {
  Fold fold;
  Places places;
  EXPECT_NO_THROW(read_yaml_text("sides: {both: true, count: 2, along: [0.5, 1]}", "s.yaml", "",
                                 described(fold), places));
  EXPECT_EQ(error_of([&] { read_settings(fold, "", {"sides.along=[0.5, 0.9]"}); }),
            "--set sides.along=[0.5, 0.9]: sides.along is a constant: [0.5, 1] m");
  EXPECT_EQ(error_of([&] { read_settings(fold, "", {"sides.both=false"}); }),
            "--set sides.both=false: sides.both is a constant: true");
  EXPECT_EQ(settings_yaml(fold).find("sides"), std::string::npos);
}

// Files of earlier versions and recorded scenarios give the value that is a constant.
TEST(YamlRead, AConstantIsTakenAtItsValueAlone) {
  const auto read = [](const std::string& yaml) {
    Fold fold;
    Places places;
    read_yaml_text(yaml, "s.yaml", "", described(fold), places);
    return fold.width;
  };
  EXPECT_EQ(read("height: 2e-3\nwidth: 0.5"), 0.5);
  EXPECT_EQ(error_of([&] { read("width: 0.5\nheight: 0.003"); }),
            "s.yaml:2: height is a constant: 0.002 m");
  EXPECT_EQ(error_of([&] { read("height: [0.002]"); }), "s.yaml:1: height is a constant: 0.002 m");
  Fold fold;
  EXPECT_EQ(error_of([&] { read_settings(fold, "", {"height=1"}); }),
            "--set height=1: height is a constant: 0.002 m");
  EXPECT_NO_THROW(read_settings(fold, "", {"height=0.002"}));
}

TEST(YamlRead, TakesEveryKindOfSetting) {
  const Scenario s = from_text(R"(
seed: 18446744073709551615
text: "Hello: world"
svg: /art/dragon.svg
home: [0, 0.5, 0, -1.2, 0, 1, 0]
speeds: [0.05, 0.1]
push:
  force: 7.5
  sensor: true
  stop_at: 3
cameras:
  - {position: [1, 2, 3], width: 320, noisy: true}
  - {}
plane:
  height: -0.2
)");
  EXPECT_EQ(s.seed, ~std::uint64_t{0});
  EXPECT_EQ(s.text, "Hello: world");
  EXPECT_EQ(s.svg, "/art/dragon.svg");
  EXPECT_EQ(s.home, (Eigen::VectorXd(7) << 0, 0.5, 0, -1.2, 0, 1, 0).finished());
  EXPECT_THAT(s.speeds, ::testing::ElementsAre(0.05, 0.1));
  EXPECT_EQ(s.push.force, 7.5);
  EXPECT_EQ(s.push.sensor, Sensor::truth);
  EXPECT_EQ(s.push.stop_at, 3.0);
  ASSERT_EQ(s.cameras.size(), 2u);
  EXPECT_EQ(s.cameras[0].position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(s.cameras[0].width, 320);
  EXPECT_TRUE(s.cameras[0].noisy);
  EXPECT_EQ(s.cameras[1].width, 640);
  ASSERT_TRUE(s.plane);
  EXPECT_EQ(s.plane->height, -0.2);
}

TEST(YamlRead, LeavesOutWhatIsNotGiven) {
  for (const char* yaml : {"", "# nothing\n", "{}", "push:\n", "push: {}", "---\n"}) {
    const Scenario s = from_text(yaml);
    EXPECT_EQ(s.push.force, 5) << yaml;
    EXPECT_EQ(s.cameras.size(), 1u) << yaml;
    EXPECT_FALSE(s.plane) << yaml;
  }
  Scenario changed;
  changed.push.force = 9;
  changed.plane.emplace();
  const Scenario s = from_text("push: {sensor: none}\nplane: null\ncameras: []", changed);
  EXPECT_EQ(s.push.force, 9);
  EXPECT_FALSE(s.plane);
  EXPECT_TRUE(s.cameras.empty());
}

TEST(YamlRead, NamesLineKeyAndNearestKey) {
  EXPECT_EQ(yaml_error("seed: 3\npush:\n  frce: 5\n"),
            "s.yaml:3: unknown key 'frce' in push; did you mean 'force'?");
  EXPECT_EQ(yaml_error("push: {banana: 5}"),
            "s.yaml:1: unknown key 'banana' in push; valid here: force, sensor, stop_at");
  EXPECT_EQ(yaml_error("\n\npsh: {}"), "s.yaml:3: unknown key 'psh'; did you mean 'push'?");
  EXPECT_EQ(yaml_error("cameras:\n  - width: 3\n  - wdth: 3\n"),
            "s.yaml:3: unknown key 'wdth' in cameras.1; did you mean 'width'?");
  EXPECT_EQ(yaml_error("push: {<<: {force: 3}}"),
            "s.yaml:1: unknown key '<<' in push; valid here: force, sensor, stop_at");
}

TEST(YamlRead, NamesWhatIsWrongWithAValue) {
  EXPECT_EQ(yaml_error("push:\n  force: 70"), "s.yaml:2: push.force is 70 N, allowed is 0 to 50 N");
  EXPECT_EQ(yaml_error("push:\n  force: abc"),
            "s.yaml:2: push.force is 'abc', which is not a number (of N)");
  EXPECT_EQ(yaml_error("push: {force: .nan}"),
            "s.yaml:1: push.force is .nan, but must be a finite number, 0 to 50 N");
  EXPECT_EQ(yaml_error("plane: {height: -.inf}"),
            "s.yaml:1: plane.height is -.inf, but must be a finite number");
  EXPECT_EQ(yaml_error("push: {stop_at: -1}"),
            "s.yaml:1: push.stop_at is -1 s, allowed is at least 0 s");
  EXPECT_EQ(yaml_error("push: {sensor: ture}"),
            "s.yaml:1: push.sensor is 'ture'; did you mean 'true'? Valid: none, true");
  EXPECT_EQ(yaml_error("cameras: [{noisy: yes}]"),
            "s.yaml:1: cameras.0.noisy is 'yes'; valid: true, false");
  EXPECT_EQ(yaml_error("home: [0, 0,\n  0, 9, 0, 0, 0]"),
            "s.yaml:2: home.3 is 9 rad, allowed is -3 to 3 rad");
  EXPECT_EQ(yaml_error("home: [0, 0, 0, .nan, 0, 0, 0]"),
            "s.yaml:1: home.3 is .nan, but must be a finite number, -3 to 3 rad");
  EXPECT_EQ(yaml_error("home: [0, 0]"), "s.yaml:1: home must be a list of 7 numbers, not 2");
  EXPECT_EQ(yaml_error("home: 3"), "s.yaml:1: home must be a list of 7 numbers");
  EXPECT_EQ(yaml_error("speeds: [1, 0]"),
            "s.yaml:1: speeds.1 is 0 m/s, allowed is more than 0 m/s");
  EXPECT_EQ(yaml_error("speeds: 1"), "s.yaml:1: speeds must be a list");
  std::string many = "seed: 1\ncameras: [{}";
  for (int i = 1; i < 5000; ++i) many += ", {}";
  EXPECT_EQ(yaml_error(many + "]"), "s.yaml:2: cameras has 5000 entries, allowed are at most 64");
  EXPECT_EQ(yaml_error("seed: 1.5"), "s.yaml:1: seed is '1.5', which is not a whole number");
  EXPECT_EQ(yaml_error("seed: [1]"), "s.yaml:1: seed must be one value (whole number), not a list");
  EXPECT_EQ(yaml_error("seed: {a: 1}"),
            "s.yaml:1: seed must be one value (whole number), not a map");
  EXPECT_EQ(yaml_error("seed:"), "s.yaml:1: seed has no value (whole number)");
  EXPECT_EQ(yaml_error("push: 5"),
            "s.yaml:1: push must hold settings of its own: force, sensor, stop_at");
  EXPECT_EQ(yaml_error("cameras: [5]"),
            "s.yaml:1: cameras.0 must hold settings of its own: position, width, noisy");
  EXPECT_THAT(yaml_error("- 1\n- 2"),
              StartsWith("s.yaml:1: a scenario must hold settings of its own: seed, text"));
}

TEST(YamlRead, RefusesWhatYamlWouldLetPass) {
  EXPECT_EQ(yaml_error("push:\n  force: 1\n  force: 2\n"), "s.yaml:3: push.force is given twice");
  EXPECT_EQ(yaml_error("seed: 1\npush: {}\nseed: 1\n"), "s.yaml:3: seed is given twice");
  EXPECT_EQ(yaml_error("[a, b]: 1"), "s.yaml:1: a key is not a word");
  // These once were read without end. Later versions of yaml-cpp say the rest themselves.
  EXPECT_THAT(yaml_error(","), StartsWith("s.yaml:1: is not valid YAML: "));
  EXPECT_THAT(yaml_error("# a comment\n, seed: 1"), StartsWith("s.yaml:2: is not valid YAML: "));
  EXPECT_THAT(set_error("home=,"), StartsWith("--set home=,: is not valid YAML: "));
  EXPECT_EQ(yaml_error("seed: 1\n---\nseed: 2\n"), "s.yaml: holds more than one YAML document");
  EXPECT_THAT(yaml_error("seed: 1\nhome: [1, 2\n"), StartsWith("s.yaml:3: is not valid YAML: "));
  EXPECT_THAT(yaml_error("seed: 1\n\tpush: 2\n"), HasSubstr("is not valid YAML: "));
  EXPECT_THAT(yaml_error("push: *nobody"), HasSubstr("is not valid YAML: "));
  EXPECT_THAT(yaml_error("seed: |\n  first\n  second\n"),
              HasSubstr("is 'first second ', which is not a whole number"));
  EXPECT_THAT(yaml_error(std::string("\0\x01\xff", 3)), StartsWith("s.yaml"));
}

class YamlFiles : public ScratchFolder {
 protected:
  std::string file_error(const std::filesystem::path& file) {
    return error_of([&] {
      Scenario s;
      read_settings(s, file);
    });
  }
};

TEST_F(YamlFiles, ExtendsAnother) {
  write("base.yaml",
        "push: {force: 7, stop_at: 2}\ncameras: [{width: 1}, {width: 2}]\nsvg: art/a.svg\n");
  write("sub/middle.yaml", "extends: ../base.yaml\npush: {sensor: true}\n");
  const auto top = write(
      "top.yaml", "push:\n  stop_at: null\ncameras: [{width: 9}]\nextends: sub/middle.yaml\n");
  Scenario s;
  const Places places = read_settings(s, top, {"push.force=8"});
  EXPECT_EQ(s.push.force, 8);
  EXPECT_EQ(s.push.sensor, Sensor::truth);
  EXPECT_FALSE(s.push.stop_at);
  ASSERT_EQ(s.cameras.size(), 1u);
  EXPECT_EQ(s.cameras[0].width, 9);
  EXPECT_EQ(s.svg, folder_ / "art/a.svg") << "relative to the file that names it";
  EXPECT_EQ(places.of("push.force"), "--set push.force=8");
  EXPECT_EQ(places.of("push.stop_at"), top.string() + ":2");
  EXPECT_EQ(places.of("svg"), (folder_ / "base.yaml").string() + ":3");
  EXPECT_EQ(places.of("cameras.0.width"), top.string() + ":3");
  EXPECT_EQ(places.of("cameras.1.width"), top.string() + ":3")
      << "the list as a whole: its old second element is gone";
  EXPECT_EQ(places.of("seed"), "default of seed");
  EXPECT_EQ(places.of("push"), "--set push.force=8") << "something in the group";
}

TEST_F(YamlFiles, ErrorsNameTheRightFile) {
  const auto base = write("base.yaml", "seed: 1\npush: {frce: 7}\n");
  const auto top = write("top.yaml", "# top\nextends: base.yaml\n");
  EXPECT_EQ(file_error(top),
            base.string() + ":2: unknown key 'frce' in push; did you mean 'force'?");
  const auto lost = write("lost.yaml", "extends: nowhere.yaml\n");
  EXPECT_EQ(file_error(lost), lost.string() + ":1: extends " + (folder_ / "nowhere.yaml").string() +
                                  ": no such file");
  const auto ring = write("ring.yaml", "extends: ring2.yaml\n");
  const auto ring2 = write("ring2.yaml", "seed: 1\nextends: ring.yaml\n");
  EXPECT_EQ(file_error(ring),
            ring2.string() + ":2: extends " + ring.string() + ", which extends this file");
  const auto self = write("self.yaml", "extends: self.yaml\n");
  EXPECT_THAT(file_error(self), HasSubstr("which extends this file"));
  const auto list = write("list.yaml", "extends: [a.yaml, b.yaml]\n");
  EXPECT_EQ(file_error(list), list.string() + ":1: extends must name one YAML file");
  const auto deep = write("deep.yaml", "push: {extends: base.yaml}\n");
  EXPECT_THAT(file_error(deep), HasSubstr("unknown key 'extends' in push"));
}

TEST_F(YamlFiles, MissingOrBrokenFile) {
  EXPECT_EQ(file_error(folder_ / "none.yaml"), (folder_ / "none.yaml").string() + ": no such file");
  EXPECT_EQ(file_error(folder_), folder_.string() + ": is a folder, must be a regular file");
  const auto huge = write("huge.yaml", std::string((1 << 20) + 1, '#'));
  EXPECT_EQ(file_error(huge), huge.string() + ": is larger than 1 MiB, which no scenario is");
  const auto deep = write("deep.yaml", std::string(100000, '['));
  EXPECT_THAT(file_error(deep), HasSubstr("is not valid YAML"));
}

TEST_F(YamlFiles, HoldNoControlCharacters) {
  const auto zero = write("zero.yaml", std::string("seed: 1\ntext: a\0n", 17));
  EXPECT_EQ(file_error(zero), zero.string() + ":2: is not valid YAML: control character \\u0000");
  const auto bell = write("bell.yaml", "text: \a\n");
  EXPECT_EQ(file_error(bell), bell.string() + ":1: is not valid YAML: control character \\u0007");
  Scenario s;
  read_settings(s, write("lines.yaml", "seed: 5\r\ntext: a\tb\r\n"));
  EXPECT_EQ(s.text, "a\tb");
}

TEST_F(YamlFiles, GiveOneLineWhateverTheyName) {
  const auto two = write("two.yaml", "extends: \"no\\nwhere.yaml\"\n");
  EXPECT_EQ(file_error(two), two.string() + ":1: extends " + folder_.string() +
                                 "/no\\u000awhere.yaml: no such file");
}

TEST(Assignments, TakeEveryKindOfSetting) {
  const Scenario s =
      with({"seed=5", "text=Hello: [world]", "svg=art/a.svg", "home=[1, 0, 0, 0, 0, 0, 0]",
            "home.6=0.5", "speeds=[0.1]", "push.sensor=true", "push.stop_at=4",
            "cameras=[{width: 1}, {width: 2}]", "cameras.1.noisy=true", "plane.height=0.3"});
  EXPECT_EQ(s.seed, 5u);
  EXPECT_EQ(s.text, "Hello: [world]");
  EXPECT_EQ(s.svg, std::filesystem::current_path() / "art/a.svg");
  EXPECT_EQ(s.home, (Eigen::VectorXd(7) << 1, 0, 0, 0, 0, 0, 0.5).finished());
  EXPECT_THAT(s.speeds, ::testing::ElementsAre(0.1));
  EXPECT_EQ(s.push.sensor, Sensor::truth);
  EXPECT_EQ(s.push.stop_at, 4.0);
  ASSERT_EQ(s.cameras.size(), 2u);
  EXPECT_TRUE(s.cameras[1].noisy);
  EXPECT_EQ(s.plane.value().height, 0.3);
  EXPECT_FALSE(with({"plane.height=0.3", "plane=null", "push.stop_at=3", "push.stop_at=~"}).plane);
  EXPECT_FALSE(with({"push.stop_at=3", "push.stop_at=~"}).push.stop_at);
  EXPECT_EQ(with({"push={force: 3}"}).push.force, 3);
  EXPECT_EQ(with({"text="}).text, "");
  EXPECT_EQ(with({"text=a=b"}).text, "a=b");
}

TEST(Assignments, SaySoWhenTheyCannotBe) {
  EXPECT_EQ(set_error("push.force=70"),
            "--set push.force=70: push.force is 70 N, allowed is 0 to 50 N");
  EXPECT_EQ(set_error("push.force=nan"),
            "--set push.force=nan: push.force is nan, but must be a finite number, 0 to 50 N");
  EXPECT_EQ(set_error("push.frce=7"),
            "--set push.frce=7: unknown key 'frce' in push; did you mean 'force'?");
  EXPECT_EQ(set_error("psh.force=7"), "--set psh.force=7: unknown key 'psh'; did you mean 'push'?");
  EXPECT_EQ(set_error("push"), "--set push: expected NAME=VALUE, as in control.normal_force=3");
  EXPECT_EQ(set_error("=3"), "--set =3: expected NAME=VALUE, as in control.normal_force=3");
  EXPECT_EQ(set_error("push.force.x=3"),
            "--set push.force.x=3: push.force is a single value and has no 'x'");
  EXPECT_EQ(set_error("cameras.1.width=3"),
            "--set cameras.1.width=3: cameras has no element '1': there are 1, counted from 0");
  EXPECT_EQ(set_error("cameras.-1.width=3"),
            "--set cameras.-1.width=3: cameras has no element '-1': there are 1, counted from 0");
  EXPECT_EQ(set_error("home.7=0"),
            "--set home.7=0: home has no element '7': there are 7, counted from 0");
  EXPECT_EQ(set_error("home.0=9"), "--set home.0=9: home.0 is 9 rad, allowed is -3 to 3 rad");
  EXPECT_EQ(set_error("home=[1"),
            "--set home=[1: is not valid YAML: end of sequence flow not found");
  EXPECT_EQ(set_error("push=3"),
            "--set push=3: push must hold settings of its own: force, sensor, stop_at");
  EXPECT_EQ(set_error("push..force=3"),
            "--set push..force=3: unknown key '' in push; valid here: force, sensor, stop_at");
  EXPECT_EQ(set_error("extends=a.yaml"),
            "--set extends=a.yaml: unknown key 'extends'; valid here: seed, text, svg, home, "
            "speeds, push, cameras, plane");
  EXPECT_EQ(set_error("push.stop_at=soon"),
            "--set push.stop_at=soon: push.stop_at is 'soon', which is not a number (of s)");
  EXPECT_THAT(set_error("text.a=" + std::string(10000, 'x')),
              ::testing::SizeIs(::testing::Lt(200u)));
}

}  // namespace
}  // namespace impedraw

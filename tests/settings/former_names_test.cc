// Settings that were renamed are read by their former names, and the user is told the new one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/settings/settings_doc.h"
#include "impedraw/settings/yaml_read.h"
#include "settings/example_settings.h"

namespace impedraw {
namespace {

using example::Scenario;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Read {
  Scenario scenario;
  Places places;
  std::vector<std::string> notes() const {
    std::vector<std::string> lines;
    for (const auto& [former, line] : places.notes()) lines.push_back(line);
    return lines;
  }
};

Read from_yaml(const std::string& yaml) {
  Read read;
  read_yaml_text(yaml, "s.yaml", ".", described(read.scenario), read.places);
  return read;
}

Read from_set(const std::vector<std::string>& assignments) {
  Read read;
  read.places = read_settings(read.scenario, "", assignments);
  return read;
}

template <class F>
std::string refusal(F&& f) {
  try {
    f();
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(FormerNames, AreReadAndNameTheNewOne) {
  const Read read = from_yaml("seed: 2\npush:\n  strength: 7\n");
  EXPECT_EQ(read.scenario.push.force, 7);
  EXPECT_THAT(read.notes(), ElementsAre("s.yaml:3: push.strength is now called push.force"));
  EXPECT_EQ(read.places.of("push.force"), "s.yaml:3");
  EXPECT_THAT(from_yaml("push: {force: 7}").notes(), ElementsAre());
}

TEST(FormerNames, AreReadFromTheCommandLine) {
  const Read read = from_set({"push.strength=8", "push.strength=9", "cameras.0.grainy=true"});
  EXPECT_EQ(read.scenario.push.force, 9);
  EXPECT_TRUE(read.scenario.cameras[0].noisy);
  EXPECT_THAT(read.notes(),
              ElementsAre("--set cameras.0.grainy=true: cameras.0.grainy is now called "
                          "cameras.0.noisy",
                          "--set push.strength=8: push.strength is now called push.force"));
  EXPECT_EQ(read.places.of("push.force"), "--set push.strength=9");
}

TEST(FormerNames, AreToldOnceForAList) {
  const Read read = from_yaml("cameras: [{grainy: true}, {noisy: true}, {grainy: true}]");
  for (const example::Camera& camera : read.scenario.cameras) EXPECT_TRUE(camera.noisy);
  EXPECT_EQ(read.notes().size(), 1u);
}

TEST(FormerNames, OfAChoiceAreRead) {
  const Read read = from_yaml("push: {sensor: real}");
  EXPECT_EQ(read.scenario.push.sensor, example::Sensor::truth);
  EXPECT_THAT(read.notes(), ElementsAre("s.yaml:1: push.sensor: real is now called true"));
  EXPECT_EQ(from_set({"push.sensor=real"}).scenario.push.sensor, example::Sensor::truth);
  EXPECT_THAT(refusal([] { from_yaml("push: {sensor: rael}"); }), HasSubstr("valid: none, true"));
}

TEST(FormerNames, ErrorsSpeakOfTheNameThatWasGiven) {
  EXPECT_EQ(refusal([] { from_yaml("push: {strength: 70}"); }),
            "s.yaml:1: push.strength is 70 N, allowed is 0 to 50 N");
  EXPECT_EQ(refusal([] { from_set({"push.strength=x"}); }),
            "--set push.strength=x: push.strength is 'x', which is not a number (of N)");
  EXPECT_EQ(refusal([] { from_yaml("push:\n  force: 3\n  strength: 4\n"); }),
            "s.yaml:3: push.force is given twice, here by its former name strength");
  EXPECT_EQ(refusal([] { from_yaml("push: {strenght: 3}"); }),
            "s.yaml:1: unknown key 'strenght' in push; did you mean 'force', formerly 'strength'?");
}

TEST(FormerNames, AreListed) {
  Scenario s;
  std::vector<std::string> lines;
  for (const RenamedSetting& r : renamed_settings(described(s)))
    lines.push_back(r.former + " → " + r.now);
  EXPECT_THAT(lines,
              ElementsAre("push.strength → push.force", "push.sensor: real → push.sensor: true",
                          "cameras.N.grainy → cameras.N.noisy"));
  EXPECT_FALSE(s.plane) << "listing them does not engage an optional";
}

}  // namespace
}  // namespace impedraw

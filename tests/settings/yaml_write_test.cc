#include "impedraw/settings/yaml_write.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cstring>
#include <random>

#include "example_settings.h"
#include "impedraw/settings/settings_doc.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {
namespace {

using example::Camera;
using example::Scenario;
using example::Sensor;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Scenario read_back(const std::string& yaml) {
  Scenario scenario;
  Places places;
  read_yaml_text(yaml, "s.yaml", "/", described(scenario), places);
  return scenario;
}

Scenario random_scenario(std::mt19937_64& random) {
  const auto number = [&](double lowest, double highest) {
    return std::uniform_real_distribution<double>(lowest, highest)(random);
  };
  Scenario s;
  s.seed = random();
  s.text.clear();
  for (int i = static_cast<int>(random() % 12); i > 0; --i)
    s.text += "aZ0:#\"'\\ \n\t{}[],&*!|>%@-?~\x01\x7f"[random() % 29];
  if (random() % 2) s.text += "ü…";
  if (random() % 2) s.svg = "/some where/a #1.svg";
  for (double& q : s.home) q = number(-3, 3);
  for (int i = static_cast<int>(random() % 4); i > 0; --i)
    s.speeds.push_back(number(1e-300, 1e-290));
  s.push.force = number(0, 50);
  s.push.sensor = random() % 2 ? Sensor::truth : Sensor::none;
  if (random() % 2) s.push.stop_at = number(0, 1e9);
  s.cameras.assign(random() % 3, Camera{});
  for (Camera& c : s.cameras)
    c = {{number(-10, 10), number(-10, 10), -0.0},
         static_cast<int>(random() % 4096) + 1,
         random() % 2 == 0};
  if (random() % 2) s.plane.emplace().height = number(-1, 1);
  return s;
}

// To the last bit: −0 is not 0 here.
bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

TEST(YamlWrite, ReadsBackAsTheSame) {
  const unsigned seed = 11;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  for (int i = 0; i < 300; ++i) {
    const Scenario a = random_scenario(random);
    const std::string yaml = settings_yaml(a);
    SCOPED_TRACE(yaml);
    const Scenario b = read_back(yaml);
    ASSERT_EQ(a.seed, b.seed);
    ASSERT_EQ(a.text, b.text);
    ASSERT_EQ(a.svg, b.svg);
    for (int j = 0; j < 7; ++j) ASSERT_TRUE(same(a.home[j], b.home[j]));
    ASSERT_EQ(a.speeds, b.speeds);
    ASSERT_TRUE(same(a.push.force, b.push.force));
    ASSERT_EQ(a.push.sensor, b.push.sensor);
    ASSERT_EQ(a.push.stop_at, b.push.stop_at);
    ASSERT_EQ(a.cameras.size(), b.cameras.size());
    for (std::size_t j = 0; j < a.cameras.size(); ++j) {
      for (int k = 0; k < 3; ++k)
        ASSERT_TRUE(same(a.cameras[j].position[k], b.cameras[j].position[k]));
      ASSERT_EQ(a.cameras[j].width, b.cameras[j].width);
      ASSERT_EQ(a.cameras[j].noisy, b.cameras[j].noisy);
    }
    ASSERT_EQ(a.plane.has_value(), b.plane.has_value());
    if (a.plane) {
      ASSERT_TRUE(same(a.plane->height, b.plane->height));
    }
    ASSERT_EQ(settings_yaml(b), yaml);
  }
}

TEST(YamlWrite, IsPlainYamlWithUnits) {
  Scenario s;
  s.push.stop_at = 2.5;
  EXPECT_EQ(
      settings_yaml(s.push),
      "force: 5                            # N: normal force asked for\n"
      "sensor: none                        # where the wrench comes from\n"
      "stop_at: 2.5                        # s: when to stop; absent: at the end of the drawing\n");
  // Another reader than ours sees the same.
  const YAML::Node node = YAML::Load(settings_yaml(s));
  EXPECT_EQ(node["push"]["force"].as<double>(), 5);
  EXPECT_EQ(node["cameras"][0]["width"].as<int>(), 640);
  EXPECT_EQ(node["home"].size(), 7u);
  EXPECT_TRUE(node["plane"].IsNull());
  EXPECT_TRUE(node["speeds"].IsSequence());
}

TEST(SettingsDoc, ListsEverySettingWithUnitLimitsAndDefault) {
  Scenario s;
  const auto rows = setting_rows(described(s));
  const auto row = [&](const std::string& name) {
    for (const auto& r : rows)
      if (r.name == name) return r;
    ADD_FAILURE() << "no row " << name;
    return SettingRow{};
  };
  EXPECT_EQ(row("push.force").initial, "5");
  EXPECT_EQ(row("push.force").limits, "0 to 50 N");
  EXPECT_EQ(row("push.sensor").type, "none | true");
  EXPECT_EQ(row("push.stop_at").initial, "none");
  EXPECT_EQ(row("cameras.N.width").initial, "640");
  EXPECT_EQ(row("home").type, "7 numbers");
  EXPECT_EQ(row("plane.height").unit, "m");
  EXPECT_EQ(row("speeds").type, "list of numbers");
  EXPECT_FALSE(s.plane) << "documenting an optional does not engage it";
  EXPECT_EQ(rows.size(), 15u);

  EXPECT_THAT(
      rows_markdown(rows),
      HasSubstr("| `push.force` | `5` | N | number, 0 to 50 N | normal force asked for |\n"));
  EXPECT_THAT(rows_markdown(rows), HasSubstr("none \\| true"));
  EXPECT_THAT(rows_text(rows),
              HasSubstr("normal force asked for [number, 0 to 50 N; default 5]\n"));
}

// Rows of made-up names: (name, heading, for users).
TEST(SettingsDoc, TiersKeepTheHeadingsOfTheirSettings) {
  const auto row = [](const char* name, bool group, bool for_users) {
    SettingRow r;
    r.name = name;
    r.group = group;
    r.for_users = for_users;
    return r;
  };
  const std::vector<SettingRow> rows = {row("name", false, true), row("a", true, false),
                                        row("a.b", true, false),  row("a.b.c", false, false),
                                        row("a.d", false, true),  row("e", true, false),
                                        row("e.f", false, false)};
  const auto names = [](const std::vector<SettingRow>& of) {
    std::vector<std::string> found;
    for (const SettingRow& r : of) found.push_back(r.name);
    return found;
  };
  EXPECT_THAT(names(of_tier(Tier::users, rows)), ElementsAre("name", "a", "a.d"));
  EXPECT_THAT(names(of_tier(Tier::experts, rows)), ElementsAre("a", "a.b", "a.b.c", "e", "e.f"));
}

// Every name that the documentation gives can be set, at its default.
TEST(SettingsDoc, NamesAreThoseOfSet) {
  for (const auto& row : setting_rows([] {
         static Scenario s;
         return described(s);
       }())) {
    if (row.group || row.initial == "none") continue;
    std::string name = row.name;
    if (const auto n = name.find(".N."); n != std::string::npos) name.replace(n, 3, ".0.");
    Scenario s;
    s.plane.emplace();
    EXPECT_NO_THROW(read_settings(s, "", {name + "=" + row.initial})) << name;
  }
}

}  // namespace
}  // namespace impedraw

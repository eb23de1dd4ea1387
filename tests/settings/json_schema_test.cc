// The JSON Schema of the example, read back by a JSON parser.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "impedraw/settings/settings_doc.h"
#include "settings/example_settings.h"

namespace impedraw {
namespace {

using Json = nlohmann::json;

const Json& schema() {
  static const Json json = Json::parse(settings_json_schema<example::Scenario>("example"));
  return json;
}

const Json& at(const std::string& pointer) { return schema().at(Json::json_pointer(pointer)); }

TEST(JsonSchema, IsOfDraft2020AndClosed) {
  EXPECT_EQ(at("/$schema"), "https://json-schema.org/draft/2020-12/schema");
  EXPECT_EQ(at("/additionalProperties"), false);
  EXPECT_EQ(at("/properties/push/additionalProperties"), false);
  EXPECT_EQ(at("/properties/cameras/items/additionalProperties"), false);
  EXPECT_EQ(at("/properties/extends/type"), "string");
}

TEST(JsonSchema, HasTypesRangesDefaultsAndUnits) {
  const Json force = at("/properties/push/properties/force");
  EXPECT_EQ(force, Json::parse(R"({"type": "number", "minimum": 0, "maximum": 50, "default": 5,
                                   "description": "normal force asked for [N]"})"));
  EXPECT_EQ(at("/properties/seed/type"), "integer");
  EXPECT_EQ(at("/properties/seed/minimum"), 0);
  EXPECT_FALSE(at("/properties/seed").contains("maximum"));
  EXPECT_EQ(at("/properties/speeds/items/exclusiveMinimum"), 0);
  EXPECT_EQ(at("/properties/speeds/default"), Json::array());
  EXPECT_EQ(at("/properties/cameras/maxItems"), 64);
  EXPECT_EQ(at("/properties/home/minItems"), 7);
  EXPECT_EQ(at("/properties/home/maxItems"), 7);
  EXPECT_EQ(at("/properties/home/items/minimum"), -3);
  EXPECT_EQ(at("/properties/home/default").size(), 7u);
  EXPECT_EQ(at("/properties/cameras/items/properties/noisy/default"), false);
  EXPECT_EQ(at("/properties/svg/type"), "string");
  EXPECT_EQ(at("/properties/text/default"), "M");
}

TEST(JsonSchema, MayBeNullWhereTheReaderTakesNull) {
  EXPECT_EQ(at("/properties/push/properties/stop_at/type"), Json({"number", "null"}));
  EXPECT_TRUE(at("/properties/push/properties/stop_at/default").is_null());
  EXPECT_EQ(at("/properties/plane/type"), Json({"object", "null"}));
}

TEST(JsonSchema, MarksFormerNamesAsDeprecated) {
  const Json old = at("/properties/push/properties/strength");
  EXPECT_EQ(old.at("deprecated"), true);
  EXPECT_EQ(old.at("maximum"), 50);
  EXPECT_FALSE(at("/properties/push/properties/force").contains("deprecated"));
  // YAML reads `true` as a truth value: both it and the word are the choice's.
  const Json sensor = at("/properties/push/properties/sensor/anyOf");
  EXPECT_EQ(sensor.at(0).at("enum"), Json({"none", true, "true"}));
  EXPECT_EQ(sensor.at(1).at("enum"), Json({"real"}));
  EXPECT_EQ(sensor.at(1).at("deprecated"), true);
  EXPECT_EQ(at("/properties/push/properties/sensor/default"), "none");
}

TEST(JsonSchema, LeavesTheSettingsAlone) {
  example::Scenario s;
  json_schema(described(s), "example");
  EXPECT_FALSE(s.plane);
  EXPECT_FALSE(s.push.stop_at);
}

}  // namespace
}  // namespace impedraw

#include "impedraw/settings/json_schema.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "impedraw/settings/yaml_read.h"

namespace impedraw {

namespace {

using Json = nlohmann::ordered_json;

Json number(double x) {
  // Writes 1 rather than 1.0, as a person would.
  if (x == std::floor(x) && std::abs(x) < 1e15) return static_cast<std::int64_t>(x);
  return x;
}

Json value_of(const Scalar& scalar) {
  const std::string text = scalar.text();
  if (scalar.type == "number" || scalar.type == "whole number") return number(std::stod(text));
  if (scalar.type == "true | false") return text == "true";
  return text;
}

void put_range(Json& json, const Range& range) {
  if (std::isfinite(range.lowest))
    json[range.above ? "exclusiveMinimum" : "minimum"] = number(range.lowest);
  if (std::isfinite(range.highest))
    json[range.below ? "exclusiveMaximum" : "maximum"] = number(range.highest);
}

// YAML reads `true` as a boolean; the program accepts it as a word.
Json words(const std::vector<std::string>& texts) {
  Json json = Json::array();
  for (const std::string& text : texts) {
    if (text == "true" || text == "false") json.push_back(text == "true");
    json.push_back(text);
  }
  return json;
}

Json type_of(const Scalar& scalar, const Range& range) {
  Json json;
  if (!scalar.words.empty()) {
    json["enum"] = words(scalar.words);
    if (!scalar.former_words.empty()) {
      Json valid = json;
      json = Json();
      json["anyOf"] = Json::array({valid});
      for (const auto& [former, now] : scalar.former_words)
        json["anyOf"].push_back({{"enum", words({former})},
                                 {"description", "Former name of " + now + "."},
                                 {"deprecated", true}});
    }
  } else if (scalar.type == "number" || scalar.type == "whole number") {
    json["type"] = scalar.type == "number" ? "number" : "integer";
    put_range(json, range);
  } else if (scalar.type == "true | false") {
    json["type"] = "boolean";
  } else if (scalar.kind == Scalar::Kind::text) {
    json["type"] = {"string", "number", "boolean"};  // `text: 2026` needs no quotes
  } else {
    json["type"] = "string";
  }
  return json;
}

Json schema_of(const Setting& setting);

Json object(const Group& group) {
  Json json;
  json["type"] = {"object", "null"};  // `push:` without content
  json["properties"] = Json::object();
  for (const Setting& field : group.fields) json["properties"][field.name] = schema_of(field);
  for (const Setting& field : group.fields) {
    for (const std::string& former : field.former_names) {
      Json alias = json["properties"][field.name];
      alias["description"] = "Former name of " + field.name + ".";
      alias["deprecated"] = true;
      json["properties"][former] = alias;
    }
  }
  json["additionalProperties"] = false;
  return json;
}

// Also accepts null.
Json nullable(Json json) {
  if (!json.contains("type")) return {{"anyOf", {json, {{"type", "null"}}}}};
  if (!json["type"].is_array()) json["type"] = Json::array({json["type"]});
  for (const Json& type : json["type"])
    if (type == "null") return json;
  json["type"].push_back("null");
  return json;
}

Json shape_of(const Setting& setting) {
  Json json;
  if (const auto* group = std::get_if<Group>(&setting.value)) return object(*group);
  if (const auto* optional = std::get_if<Optional>(&setting.value)) {
    const bool engaged = optional->engaged();
    optional->engage(true);
    json = nullable(shape_of(optional->value()));
    optional->engage(engaged);
    if (!engaged) json["default"] = nullptr;
  } else if (const auto* list = std::get_if<List>(&setting.value)) {
    const auto [owner, element] = list->sample();
    json["type"] = "array";
    json["items"] = shape_of(element);
    json["items"].erase("default");
    json["maxItems"] = most_entries;
    if (list->or_one) json = {{"anyOf", {json["items"], json}}};
    if (list->size() == 0) json["default"] = Json::array();
  } else if (const auto* numbers = std::get_if<Numbers>(&setting.value)) {
    json["type"] = "array";
    json["items"]["type"] = "number";
    put_range(json["items"], numbers->range);
    json["minItems"] = json["maxItems"] = numbers->size;
    json["default"] = Json::array();
    for (int i = 0; i < numbers->size; ++i) json["default"].push_back(number(numbers->data[i]));
  } else {
    const auto& scalar = std::get<Scalar>(setting.value);
    json = type_of(scalar, setting.range);
    json["default"] = value_of(scalar);
  }
  return json;
}

Json schema_of(const Setting& setting) {
  const std::string unit = setting.unit.empty() ? "" : " [" + setting.unit + "]";
  Json json;
  json["description"] = setting.help + unit;
  json.update(shape_of(setting));
  return json;
}

}  // namespace

std::string json_schema(const Group& settings, const std::string& title) {
  Json json;
  json["$schema"] = "https://json-schema.org/draft/2020-12/schema";
  json["title"] = title;
  json.update(object(settings));
  json["properties"]["extends"] = {
      {"description",
       "Another scenario file, relative to this file's folder: everything in it holds first."},
      {"type", "string"}};
  return json.dump(2) + "\n";
}

}  // namespace impedraw

#include "impedraw/settings/settings_doc.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/settings/yaml_read.h"

namespace impedraw {

namespace {

void put(std::vector<SettingRow>& rows, const std::string& name, const Setting& setting,
         const Setting& described_by);

SettingRow row(const std::string& name, std::string type, std::string initial, const Setting& by) {
  return {name,    std::move(type), std::move(initial), range_text(by.range, by.unit), by.unit,
          by.help, false,           by.for_users};
}

void put_fields(std::vector<SettingRow>& rows, const std::string& name, const Group& group) {
  for (const Setting& field : group.fields)
    put(rows, name.empty() ? field.name : name + "." + field.name, field, field);
}

void put_list(std::vector<SettingRow>& rows, const std::string& name, const List& list,
              const Setting& by) {
  const auto [owner, element] = list.sample();
  if (const auto* scalar = std::get_if<Scalar>(&element.value)) {
    std::vector<std::string> words;
    for (std::size_t i = 0; i < list.size(); ++i)
      words.push_back(std::get<Scalar>(list.element(i).value).text());
    rows.push_back(row(name,
                       (list.or_one ? scalar->type + " or " : "") + "list of " + scalar->type + "s",
                       "[" + joined(words) + "]", by));
    return;
  }
  rows.push_back(row(name, "list", fmt::format("{} of them", list.size()), by));
  rows.back().group = true;
  put_fields(rows, name + ".N", std::get<Group>(element.value));
}

void put(std::vector<SettingRow>& rows, const std::string& name, const Setting& setting,
         const Setting& by) {
  if (const auto* group = std::get_if<Group>(&setting.value)) {
    rows.push_back(row(name, "group", "", by));
    rows.back().group = true;
    put_fields(rows, name, *group);
  } else if (const auto* list = std::get_if<List>(&setting.value)) {
    put_list(rows, name, *list, by);
  } else if (const auto* optional = std::get_if<Optional>(&setting.value)) {
    const bool engaged = optional->engaged();
    optional->engage(true);
    const std::size_t first = rows.size();
    put(rows, name, optional->value(), by);
    if (!engaged) rows[first].initial = "none";
    optional->engage(engaged);
  } else if (const auto* numbers = std::get_if<Numbers>(&setting.value)) {
    std::vector<std::string> words;
    for (int i = 0; i < numbers->size; ++i) words.push_back(number_text(numbers->data[i]));
    rows.push_back(
        row(name, fmt::format("{} numbers", numbers->size), "[" + joined(words) + "]", by));
  } else {
    const auto& scalar = std::get<Scalar>(setting.value);
    rows.push_back(row(name, scalar.type, scalar.text(), by));
  }
}

void put_renamed(std::vector<RenamedSetting>& renamed, const std::string& name,
                 const Setting& setting) {
  if (const auto* group = std::get_if<Group>(&setting.value)) {
    const std::string head = name.empty() ? "" : name + ".";
    for (const Setting& field : group->fields) {
      for (const std::string& former : field.former_names)
        renamed.push_back({head + former, head + field.name});
      put_renamed(renamed, head + field.name, field);
    }
  } else if (const auto* list = std::get_if<List>(&setting.value)) {
    const auto [owner, element] = list->sample();
    put_renamed(renamed, name + ".N", element);
  } else if (const auto* optional = std::get_if<Optional>(&setting.value)) {
    const bool engaged = optional->engaged();
    optional->engage(true);
    put_renamed(renamed, name, optional->value());
    optional->engage(engaged);
  } else if (const auto* scalar = std::get_if<Scalar>(&setting.value)) {
    for (const auto& [former, now] : scalar->former_words)
      renamed.push_back({name + ": " + former, name + ": " + now});
  }
}

std::string cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2)
    text.insert(at, "\\");
  return text;
}

}  // namespace

std::vector<SettingRow> setting_rows(const Group& settings) {
  std::vector<SettingRow> rows;
  put_fields(rows, "", settings);
  return rows;
}

std::vector<SettingRow> of_tier(Tier tier, const std::vector<SettingRow>& rows) {
  std::vector<SettingRow> kept;
  for (const SettingRow& row : rows) {
    // A heading without a setting of this tier gives way to the next that is not below it.
    while (!kept.empty() && kept.back().group && !row.name.starts_with(kept.back().name + "."))
      kept.pop_back();
    if (row.group || row.for_users == (tier == Tier::users)) kept.push_back(row);
  }
  while (!kept.empty() && kept.back().group) kept.pop_back();
  return kept;
}

std::vector<RenamedSetting> renamed_settings(const Group& settings) {
  std::vector<RenamedSetting> renamed;
  put_renamed(renamed, "", Setting{"", "", "", Range::any(), settings});
  return renamed;
}

std::string rows_markdown(const std::vector<SettingRow>& rows) {
  std::string text =
      "| setting | default | unit | what is allowed | meaning |\n|---|---|---|---|---|\n";
  for (const SettingRow& r : rows) {
    if (r.group) {
      text += fmt::format("| **{}** | {} | | | {} |\n", r.name, r.initial, cell(r.help));
      continue;
    }
    const std::string initial = r.initial.empty() ? "" : "`" + cell(r.initial) + "`";
    const std::string allowed = r.limits.empty() ? r.type : r.type + ", " + r.limits;
    text += fmt::format("| `{}` | {} | {} | {} | {} |\n", r.name, initial, r.unit, cell(allowed),
                        cell(r.help));
  }
  return text;
}

std::string rows_text(const std::vector<SettingRow>& rows) {
  std::size_t width = 0;
  for (const SettingRow& r : rows) width = std::max(width, r.name.size());
  std::string text;
  for (const SettingRow& r : rows) {
    if (r.group) {
      text += fmt::format("\n{:<{}}  {}{}\n", r.name, width, r.help,
                          r.initial.empty() ? "" : " (" + r.initial + ")");
      continue;
    }
    const std::string unit = r.unit.empty() ? "" : " of " + r.unit;  // limits already contain it
    text += fmt::format("{:<{}}  {} [{}{}; default {}]\n", r.name, width, r.help, r.type,
                        r.limits.empty() ? unit : ", " + r.limits,
                        r.initial.empty() ? "empty" : r.initial);
  }
  return text;
}

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

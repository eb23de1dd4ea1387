#include "impedraw/settings/settings_doc.h"

#include <fmt/format.h>

#include <algorithm>

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

}  // namespace impedraw

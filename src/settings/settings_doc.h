// Lists all settings for docs/settings.md, the settings command and a JSON Schema, from the
// description that also reads them.
#pragma once

#include <string>
#include <vector>

#include "impedraw/settings/schema.h"

namespace impedraw {

struct SettingRow {
  std::string name;     // "push.force", "cameras.N.noise" for each element of a list
  std::string type;     // "number", "3 numbers", "none | true"
  std::string initial;  // the default; "none" for an absent optional
  std::string limits;   // "0 to 50 N"
  std::string unit;
  std::string help;
  bool group = false;  // a heading: a struct or a list of them
  bool for_users = false;
};

// A setting belongs to one tier: what a user of the program sets, or what an expert on the arm
// does.
enum class Tier { users, experts };

// In the description's order. `settings` must be bound to defaults and is left unchanged.
std::vector<SettingRow> setting_rows(const Group& settings);

// The rows of one tier, with the headings that they stand under.
std::vector<SettingRow> of_tier(Tier tier, const std::vector<SettingRow>& rows);

// A renamed setting, or a renamed word of a choice ("control.wrench: true").
struct RenamedSetting {
  std::string former;
  std::string now;
};
std::vector<RenamedSetting> renamed_settings(const Group& settings);

std::string rows_markdown(const std::vector<SettingRow>& rows);
std::string rows_text(const std::vector<SettingRow>& rows);  // for a terminal, one setting per line

// Writes a settings description as a JSON Schema (draft 2020-12), with which editors complete and
// check a scenario. Former names and words are included and marked as deprecated. Only the program
// checks numbers given twice, whether files exist, and settings that do not go together.

// `settings` must be bound to defaults and is left unchanged. The text ends with a line feed.
std::string json_schema(const Group& settings, const std::string& title);

template <Described T>
std::string settings_json_schema(const std::string& title) {
  T defaults;
  return json_schema(described(defaults), title);
}

}  // namespace impedraw

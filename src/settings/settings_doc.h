// Lists all settings for docs/settings.md and the settings command, from the description that also
// reads them.
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

}  // namespace impedraw

// Writes a settings description as a JSON Schema (draft 2020-12), with which editors complete and
// check a scenario. Former names and words are included and marked as deprecated. Only the program
// checks numbers given twice, whether files exist, and settings that do not go together.
#pragma once

#include <string>

#include "impedraw/settings/schema.h"

namespace impedraw {

// `settings` must be bound to defaults and is left unchanged. The text ends with a line feed.
std::string json_schema(const Group& settings, const std::string& title);

template <Described T>
std::string settings_json_schema(const std::string& title) {
  T defaults;
  return json_schema(described(defaults), title);
}

}  // namespace impedraw

// Writes all settings as YAML, each line with its unit and meaning. Reading it back gives exactly
// the same settings: a double is written as the shortest text that reads back as the same number.
#pragma once

#include <string>

#include "impedraw/settings/schema.h"

namespace impedraw {

std::string yaml_text(const Group& settings);

template <Described T>
std::string settings_yaml(T settings) {
  return yaml_text(described(settings));
}

}  // namespace impedraw

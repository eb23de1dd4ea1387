// A scenario of this repository, prepared.
#pragma once

#include <string>
#include <vector>

#include "impedraw/experiment/prepare.h"

namespace impedraw {

inline Prepared prepared(const std::string& name,
                         const std::vector<std::string>& assignments = {}) {
  DrawOptions options;
  options.scenario = "scenarios/" + name + ".yaml";
  options.assignments = assignments;
  return prepare(resolve(options));
}

}  // namespace impedraw

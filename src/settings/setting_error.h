// Says where the setting was given that an error is about.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "impedraw/common/errors.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

class SettingErrors {
 public:
  explicit SettingErrors(const Places& places) : places_(places) {}

  // Throws `what`, opened by the place of the first of `names` that anybody gave ("x.yaml:3: ...");
  // as it is where all have their defaults.
  [[noreturn]] void raise(const std::vector<std::string>& names, const std::string& what) const {
    for (const std::string& name : names) {
      const std::string place = places_.of(name);
      if (!place.starts_with("default of ")) throw InputError(place + ": " + what);
    }
    throw InputError(what);
  }

  // What step() returns; its InputErrors as above.
  template <class Step>
  decltype(auto) locate(const std::vector<std::string>& names, Step&& step) const {
    try {
      return std::forward<Step>(step)();
    } catch (const InputError& error) {
      raise(names, error.what());
    }
  }

 private:
  const Places& places_;
};

}  // namespace impedraw

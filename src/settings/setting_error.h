// Attaches a setting's source location to an error.
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

  // Throws InputError with `what`, preceded by the location of the first of `names` that was given
  // ("x.yaml:3: ..."). If all have their defaults, throws `what` alone.
  [[noreturn]] void raise(const std::vector<std::string>& names, const std::string& what) const {
    for (const std::string& name : names) {
      const std::string place = places_.of(name);
      if (!place.starts_with("default of ")) throw InputError(place + ": " + what);
    }
    throw InputError(what);
  }

  // Returns step(); raises its InputErrors as above.
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

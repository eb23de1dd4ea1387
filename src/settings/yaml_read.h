// Reads settings from YAML files and the command line. Rejects unknown names, duplicates and values
// out of range.
//
// scenarios/bowl-m.yaml:
//   extends: bowl-sine.yaml      # all settings of that file, relative to this one's folder
//   drawing: {shape: M}          # then the differences
//
// Maps are merged key by key; lists are replaced as a whole; null makes an optional setting absent.
// Settings that a file omits keep the object's value. `extends` is allowed at the top level only
// and may chain over several files.
//
// A setting may be given by its former name; Places::notes() then gives the current one.
//
// Every error is a one-line InputError that begins with its location:
//   scenarios/bowl-m.yaml:12: unknown key 'frce' in push; did you mean 'force'?
//   scenarios/bowl-m.yaml:12: push.force is 70 N, allowed is 0 to 50 N
//   --set push.force=abc: push.force is 'abc', which is not a number (of N)
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "impedraw/settings/schema.h"

namespace impedraw {

// Limit of any list: nobody has more cameras, marks, pushes or joints, and each costs memory.
constexpr std::size_t most_entries = 64;

// The source of each given setting: "push.force" → "scenarios/bowl-m.yaml:12" or
// "--set push.force=3". Settings without an entry have their defaults. Used for errors that only
// show up later, when settings are checked together.
class Places {
 public:
  // The place of the setting, or of a setting that contains it or that it contains; "default of
  // push.force" if none was given.
  std::string of(const std::string& setting) const;
  void put(const std::string& setting, std::string place) { places_[setting] = std::move(place); }
  void forget(const std::string& setting);  // with all that it contains

  // Renames a setting, with all that it contains, that was given at `place` by a former name.
  void rename(const std::string& given, const std::string& now, const std::string& place);
  // Adds a note for the user, keyed by former name, about the first place where it was given:
  //   x.yaml:3: control.push is now called control.normal_force
  void note(const std::string& given, const std::string& now, const std::string& place);
  const std::map<std::string, std::string>& notes() const { return notes_; }

 private:
  std::map<std::string, std::string> places_;
  std::map<std::string, std::string> notes_;
};

void read_yaml_file(const std::filesystem::path& file, const Group& settings, Places& places);
// `text` is the content of a file named `name`. The files it extends and its paths are relative to
// `folder`.
void read_yaml_text(const std::string& text, const std::string& name,
                    const std::filesystem::path& folder, const Group& settings, Places& places);
// Reads one assignment: "push.force=3", "home=[0, 0.5, 0]", "home.1=0.5", "cameras.0.noise=0.001",
// "stop_at=null". Single values are taken literally, without YAML quotes; lists, vectors and
// structs are YAML.
void read_assignment(const std::string& assignment, const Group& settings, Places& places);

// Reads the file, then the assignments in order. An empty file name reads no file.
template <Described T>
Places read_settings(T& settings, const std::filesystem::path& file,
                     const std::vector<std::string>& assignments = {}) {
  Places places;
  // The description stays bound to the object and does not change during reading: lists describe
  // their elements anew.
  const Group group = described(settings);
  if (!file.empty()) read_yaml_file(file, group, places);
  for (const std::string& assignment : assignments) read_assignment(assignment, group, places);
  return places;
}

}  // namespace impedraw

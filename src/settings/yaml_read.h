// Settings from YAML files and from the command line, strictly: nothing unknown, nothing twice,
// nothing out of range.
//
//   scenarios/bowl-m.yaml          extends: bowl-sine.yaml      # first everything of that file,
//   relative to this one's folder
//                                  drawing: {shape: M}          # then what differs
//
// Maps are merged key by key; lists replace as a whole; null makes an optional setting absent. A
// file need not name every setting: what it leaves out keeps the value that the object had.
// `extends` stands at the top level only, and may go on over several files.
//
// A former name of a setting is read as the setting; Places::notes() says what it is called now.
//
// Every error is an InputError of one line, which opens with where it stands:
//   scenarios/bowl-m.yaml:12: unknown key 'frce' in push; did you mean 'force'?
//   scenarios/bowl-m.yaml:12: push.force is 70 N, allowed is 0 to 50 N
//   --set push.force=abc: push.force is 'abc', which is not a number (of N)
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "impedraw/settings/schema.h"

namespace impedraw {

// Where each setting that was given got its value: "push.force" → "scenarios/bowl-m.yaml:12" or
// "--set push.force=3". What stands in no entry has its default. For errors that show only later,
// when settings are seen together.
class Places {
 public:
  // The place of the setting or of what lies around or in it, "default of push.force" when nobody
  // gave it.
  std::string of(const std::string& setting) const;
  void put(const std::string& setting, std::string place) { places_[setting] = std::move(place); }
  void forget(const std::string& setting);  // with all that lies in it

  // A setting, with all that lies in it, that was given at `place` by a former name.
  void rename(const std::string& given, const std::string& now, const std::string& place);
  // By former name, a line for the user about the first place where it was given:
  //   x.yaml:3: control.push is now called control.normal_force
  void note(const std::string& given, const std::string& now, const std::string& place);
  const std::map<std::string, std::string>& notes() const { return notes_; }

 private:
  std::map<std::string, std::string> places_;
  std::map<std::string, std::string> notes_;
};

void read_yaml_file(const std::filesystem::path& file, const Group& settings, Places& places);
// `text` stands for a file named `name`; what it extends, and its paths, are relative to `folder`.
void read_yaml_text(const std::string& text, const std::string& name,
                    const std::filesystem::path& folder, const Group& settings, Places& places);
// "push.force=3", "home=[0, 0.5, 0]", "home.1=0.5", "cameras.0.noise=0.001", "stop_at=null": single
// values as they are, without YAML's quotes; lists, vectors and structs as YAML.
void read_assignment(const std::string& assignment, const Group& settings, Places& places);

// File first, then the assignments in their order. An empty file name reads none.
template <Described T>
Places read_settings(T& settings, const std::filesystem::path& file,
                     const std::vector<std::string>& assignments = {}) {
  Places places;
  // The description is bound to the object and does not change while it is read: lists describe
  // their elements anew.
  const Group group = described(settings);
  if (!file.empty()) read_yaml_file(file, group, places);
  for (const std::string& assignment : assignments) read_assignment(assignment, group, places);
  return places;
}

}  // namespace impedraw

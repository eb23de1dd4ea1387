#include "impedraw/run/run_inputs.h"

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/log/log.h"
#include "impedraw/run/run_folder.h"
#include "impedraw/settings/yaml_read.h"
#include "impedraw/settings/yaml_write.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;

constexpr const char* kSettings = "settings";
constexpr const char* kInputs = "inputs";

// In inputs/. Two inputs may have the same name in different folders.
std::string name_of(const std::vector<KeptInput>& inputs, const KeptInput& input) {
  const std::string name = input.file.filename().string();
  for (const KeptInput& earlier : inputs) {
    if (&earlier == &input) break;
    if (earlier.file.filename() == input.file.filename()) return input.setting + "-" + name;
  }
  return name;
}

struct Recorded {
  std::string sha256;
  fs::path copy;
};

}  // namespace

std::map<std::string, std::string> record_of(const Scenario& scenario,
                                             const std::vector<KeptInput>& inputs) {
  std::map<std::string, std::string> record = {{kSettings, settings_yaml(scenario)}};
  for (const KeptInput& input : inputs)
    record["input " + input.setting] = input.sha256 + " " + name_of(inputs, input);
  return record;
}

void write_inputs(const fs::path& folder, const Scenario& scenario,
                  const std::vector<KeptInput>& inputs) {
  write_whole(folder / "scenario.yaml", settings_yaml(scenario));
  const fs::path copies = folder / kInputs;
  std::error_code error;
  const fs::file_type type = fs::symlink_status(copies, error).type();
  if (type != fs::file_type::not_found && type != fs::file_type::directory)
    throw InputError(fmt::format("{}: is a link or a file; a folder is needed", copies.string()));
  make_folder(copies);
  for (const KeptInput& input : inputs) write_whole(copies / name_of(inputs, input), input.content);
}

Scenario recorded_scenario(const fs::path& folder, Places* places) {
  Scenario scenario;
  const fs::path file = folder / "scenario.yaml";
  const auto attributes = log_attributes(folder / "run.h5");
  if (const auto settings = attributes.find(kSettings); settings != attributes.end()) {
    read_yaml_text(settings->second, (folder / "run.h5").string(), folder, described(scenario),
                   *places);
  } else {
    *places = read_settings(scenario, file);
  }
  return scenario;
}

void find_inputs(Scenario* scenario, const fs::path& folder, InputsFrom from) {
  std::map<std::string, Recorded> recorded;
  for (const auto& [key, text] : log_attributes(folder / "run.h5")) {
    if (!key.starts_with("input ") || text.size() < 66) continue;
    // Only a name: a log is no reason to read a file elsewhere.
    recorded[key.substr(6)] = {text.substr(0, 64),
                               folder / kInputs / fs::path(text.substr(65)).filename()};
  }
  const bool urdf_given = !scenario->arm.urdf.empty();
  bool urdf_moved = false;
  visit_input_files(*scenario, [&](const std::string& setting, fs::path& file) {
    const auto found = recorded.find(setting);
    if (found == recorded.end()) return;
    const auto& [hash, copy] = found->second;
    const bool copied = is_own_file(copy);
    std::error_code error;
    const bool there = fs::exists(file, error);
    const fs::path taken = from == InputsFrom::originals ? (there || !copied ? file : copy)
                                                         : (copied || !there ? copy : file);
    if (sha256_of_file(taken) != hash)
      throw InputError(
          from == InputsFrom::originals
              ? fmt::format(
                    "--resume: {} ({}) is not the file that the run in {} was started with{}; "
                    "draw the changed one into a new folder",
                    taken.string(), setting, folder.string(),
                    copied && taken != copy ? ", of which " + copy.string() + " is a copy" : "")
              : fmt::format("{} ({}) is missing or not the file that the run in {} was made from",
                            taken.string(), setting, folder.string()));
    if (setting == "arm.urdf") urdf_moved = taken != file;
    file = taken;
  });
  if (!urdf_given && !urdf_moved) scenario->arm.urdf.clear();
}

}  // namespace impedraw

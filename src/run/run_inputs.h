// The inputs of a run: the log carries its settings and the hashes of its input files, the
// folder has copies of them (inputs/). A run can so be continued and reported wherever its folder
// is, and what has been edited since is noticed.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "impedraw/experiment/input_files.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

// The log's attributes for them. Each input has "input <setting>": "<SHA-256> <name in inputs/>".
std::map<std::string, std::string> record_of(const Scenario& scenario,
                                             const std::vector<KeptInput>& inputs);

// Writes scenario.yaml and inputs/.
void write_inputs(const std::filesystem::path& folder, const Scenario& scenario,
                  const std::vector<KeptInput>& inputs);

// The settings with which the run in `folder` was begun: the log's, or scenario.yaml's where an
// older version wrote the log. Throws InputError if there are none.
Scenario recorded_scenario(const std::filesystem::path& folder, Places* places);

enum class InputsFrom {
  originals,  // of a run that goes on: the files themselves; the copies where they are gone
  folder      // the copies; the files themselves where copies are gone
};

// Lets the scenario read its inputs from where they are. Throws InputError naming an input that is
// not what the run was started with. Logs of older versions have no hashes: nothing is compared.
void find_inputs(Scenario* scenario, const std::filesystem::path& folder, InputsFrom from);

}  // namespace impedraw

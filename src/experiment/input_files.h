// The files that a scenario reads: artwork, mesh and URDF, as they were when the run was prepared.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/experiment/scenario.h"

namespace impedraw {

struct KeptInput {
  std::string setting;         // "drawing.svg"
  std::filesystem::path file;  // as the scenario names it
  std::string content;
  std::string sha256;  // of the content
};

// Calls visit(name of the setting, its path) for each setting of the scenario that names a file it
// reads. The path of the default arm is filled in.
void visit_input_files(
    Scenario& scenario,
    const std::function<void(const std::string&, std::filesystem::path&)>& visit);

// Leaves out what is no regular file, cannot be read, or has over 1 GB: reading it as what it
// should be tells why.
std::vector<KeptInput> read_input_files(Scenario scenario);

// The URDF that the settings name or imply, and the model of it, with its rotors; of a
// simulated arm also with the damping that the URDF gives it. Throws InputError.
std::filesystem::path urdf_of(const ArmSettings& settings);
ArmModel model_of(const ArmSettings& settings);

// The SHA-256 of a file; empty if it cannot be read.
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace impedraw

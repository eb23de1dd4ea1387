// What the command line says of one drawing, and the scenario that it comes to.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "impedraw/experiment/scenario.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

struct DrawOptions {
  std::filesystem::path scenario;  // empty: the standard sine on the bowl
  std::string shape;
  std::filesystem::path svg;
  std::string text;  // to write
  bool no_perception = false;
  bool keep_order = false;               // of a file's strokes
  bool skip_unreachable = false;         // what fails the pre-flight is left out
  std::string place = "fixed";           // of the canvas before the arm: fixed, auto
  bool resume = false;                   // goes on with the run in `out`
  std::filesystem::path out;             // empty: runs/<name> in the working directory
  std::vector<std::string> assignments;  // --set
};

// The scenario with everything from the command line in it, and in `places` who gave what. Throws
// InputError.
Scenario resolve(const DrawOptions& options, Places* places = nullptr);

}  // namespace impedraw

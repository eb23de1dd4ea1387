// What the command line does, each as a function that returns the program's exit code.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/scenario.h"
#include "app/yaml_read.h"

namespace impedraw {

enum ExitCode { kFinished = 0, kMissed = 1, kBadInput = 2, kStopped = 3, kInterrupted = 130 };

struct DrawOptions {
  std::filesystem::path scenario;        // empty: the standard sine on the bowl
  std::string shape;
  std::filesystem::path svg;
  std::string text;                      // to write
  bool no_perception = false;
  bool keep_order = false;               // of a file's strokes
  bool skip_unreachable = false;         // what fails the pre-flight is left out
  std::string place = "fixed";           // of the canvas before the arm: fixed, auto
  bool resume = false;                   // goes on with the run in `out`
  std::filesystem::path out;             // empty: runs/<name> in the working directory
  std::vector<std::string> assignments;  // --set
};

// The scenario with everything from the command line in it, and in `places` who gave what. Throws InputError.
Scenario resolve(const DrawOptions& options, Places* places = nullptr);

// With canvas and drawing moved to where the arm reaches them best, if the options ask for that; says so.
Scenario placed(const DrawOptions& options, const Scenario& scenario, const Places& places);

int draw(const DrawOptions& options);
int plan(const DrawOptions& options, bool as_json);    // the pre-flight alone, with a picture; kMissed where something cannot be drawn
int compare(const DrawOptions& options);               // with and without perception, side by side
int report(const std::filesystem::path& folder);       // metrics, pictures and report of a run again, from its log
int calibrate_tool(const DrawOptions& options, int poses);  // mass and centre of mass of the tool, on the simulated arm
int print_settings(bool markdown);                      // every setting; markdown: as docs/settings.md has them

}  // namespace impedraw

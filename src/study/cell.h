// A cell of a table of experiments (cell_table.h): one scenario that can also be run alone.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "impedraw/experiment/scenario.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

struct Cell {
  std::string name;   // "matrix-nominal-50mm_s-30deg-5N"; unique
  std::string group;  // "matrix"; what it is one of
  std::string base;   // "scenarios/robustness-nominal.yaml", from the root of the tree
  std::vector<std::string> assignments;  // "control.normal_force=5", as --set takes them
  // Position in the page: heading, row and column, and the text before the cell's figures.
  std::string table, row, column, value;
  bool realistic = false;
  // "artwork/koi.svg", as --svg takes it, from the root of the tree; empty: the scenario's
  std::string svg = {};
};

// Throws InputError if the assignments are invalid.
Scenario cell_scenario(const Cell& cell, Places* places = nullptr);

// "./impedraw draw scenarios/… --set …", quoted for a shell.
std::string cell_command(const Cell& cell);

// Every setting that is no group, by its full name: "control.normal_force" → "5".
std::map<std::string, std::string> flat_settings(Scenario scenario);

// Replaces absolute paths into the source tree by relative ones, so that tables do not depend on
// the machine.
std::string within_tree(std::string text);

}  // namespace impedraw

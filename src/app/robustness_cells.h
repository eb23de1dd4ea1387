// The cells of ./impedraw robustness: each one scenario, as anybody can run it alone.
//
// matrix   10, 50, 100, 200 mm/s × slopes 0, 15, 30, 45, 60° × pushes of 1, 5, 20 N, nominal and realistic: a circle on a leaning plane
// error    each error of what is believed alone, at three values, on the standard sine; `none` is what they compare with
// canvas   each shape at 50 mm/s and 5 N, nominal and realistic
// switch   observer, rejection of tip friction, force integral: off and on, under what each is there for
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/scenario.h"
#include "app/yaml_read.h"

namespace impedraw {

struct Cell {
  std::string name;                      // "matrix-nominal-50mm_s-30deg-5N"; unique
  std::string group;                     // matrix, error, canvas, switch
  std::string base;                      // "scenarios/robustness-nominal.yaml", from the root of the tree
  std::vector<std::string> assignments;  // "control.push=5", as --set takes them
  // Where it stands in robustness.md: a heading, the row and the column under it, and what is written before its figures.
  std::string table, row, column, value;
  bool realistic = false;
};

std::vector<Cell> robustness_cells();

// Throws InputError where the assignments cannot be read.
Scenario cell_scenario(const Cell& cell, Places* places = nullptr);

// "./impedraw draw scenarios/… --set …", quoted for a shell.
std::string cell_command(const Cell& cell);

}  // namespace impedraw

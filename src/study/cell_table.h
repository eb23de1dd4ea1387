// A table of experiments, measured cell by cell in processes of their own: ./impedraw robustness,
// ./impedraw reach.
//
// The folder gets NAME.csv, a line as each cell ends, so that whatever ends the program loses none
// that was done, and at the end NAME.md and NAME.png. Started again with the same folder it keeps
// the lines whose settings are still the same and runs the rest.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "impedraw/study/cell.h"
#include "impedraw/study/cell_processes.h"
#include "impedraw/study/csv.h"

namespace impedraw {

struct CellTableOptions {
  std::filesystem::path out;  // empty: runs/NAME in the working directory
  int jobs = 0;               // 0: as many as there are cores
  std::string only;           // a regular expression, somewhere in the name; empty: all
  bool again = false;         // keeps nothing of an earlier run
  bool list = false;          // prints names and commands, runs nothing
};

using Records = std::map<std::string, Record>;  // by the cell's name

struct CellTable {
  std::string
      // of the command, its files, and src/report/NAME.py, which plots: arguments CSV and PNG
      name;
  std::vector<std::string> columns;  // `cell` and `failed` (0, 1) among them
  std::function<bool(const Record&, const Cell&)>
      same;  // was the line made of the cell's settings?
  std::function<std::string(const Cell&, const std::filesystem::path& log)>
      measure;                                                   // in a process of its own
  std::function<Record(const Cell&, const ProcessEnd&)> record;  // the line of what that gave
  std::function<std::string(const Records&)> page;               // NAME.md
  double time_limit = 120.0;                                     // of a cell, wall time [s]
};

// The folder that the options ask for.
std::filesystem::path table_folder(const std::string& name, const CellTableOptions& options);

// The cells that --only asks for. InputError where that is no expression, or none.
std::vector<Cell> matching(const std::vector<Cell>& cells, const std::string& pattern);

void print_cells(const std::vector<Cell>& cells);  // name and command of each

// The program's exit code: 0 when every cell of `desired` was run, also where some failed; `all`
// sets the order. Throws InputError.
int run_table(const CellTable& table, const std::vector<Cell>& all,
              const std::vector<Cell>& desired, const CellTableOptions& options);

}  // namespace impedraw

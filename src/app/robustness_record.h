// robustness.csv: one line a cell, appended as cells end, so that whatever ends the program loses none that was done.
//
// Columns   cell, group, base, set, failed (0, 1), cause, speed [mm/s], slope [deg], push [N], realistic (0, 1), every setting in which any
//           two cells differ, every metric of metrics.json (empty where it is null), wall_time [s]
// slope     steepest under the target line, against the level; empty where the cell was refused before that was known
// Fields with a comma, a quote or a bracket stand in quotes (RFC 4180); no field has a line break in it.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/robustness_cells.h"

namespace impedraw {

// What became of a cell.
struct CellResult {
  std::string cause;               // of failure; empty: it did not fail
  nlohmann::json metrics;          // null where there was no run
  std::string slope;               // [deg], as above
  double wall_time = 0.0;          // [s]
};

using Record = std::map<std::string, std::string>;  // a line, by column

class RecordColumns {
 public:
  // `all`: every cell there is, also those that are not run.
  explicit RecordColumns(const std::vector<Cell>& all);

  const std::vector<std::string>& names() const { return names_; }
  Record settings(const Cell& cell) const;                            // what is known before it is run
  Record record(const Cell& cell, const CellResult& result) const;    // and after
  bool same_settings(const Record& line, const Cell& cell) const;     // made of the same settings, base and --set
  std::string line(const Record& record) const;                       // with its line break

 private:
  std::vector<std::string> names_, varied_;
};

std::string csv_line(const std::vector<std::string>& fields);
// The lines after the first by the first's names. A line that was cut off, or that has not as many fields, is left out.
std::vector<Record> read_csv(const std::filesystem::path& file);

// Every setting that is no group, by its full name: "control.push" → "5".
std::map<std::string, std::string> flat_settings(Scenario scenario);

}  // namespace impedraw

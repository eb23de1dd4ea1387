// robustness.csv: one line per cell, appended as cells end, so that an abort loses no finished
// cell.
//
// Columns   cell, group, base, set, failed (0, 1), cause, speed [mm/s], slope [deg], push [N],
//           realistic (0, 1), every setting in which any
//           two cells differ, every metric of metrics.json (empty where it is null), wall_time [s]
// slope     steepest under the target line, against the level; empty where the cell was refused
//           before that was known
#pragma once

#include <map>
#include <string>
#include <vector>

#include "impedraw/study/csv.h"
#include "impedraw/study/robustness_cells.h"

namespace impedraw {

// The result of a cell.
struct CellResult {
  std::string cause;                      // of failure; empty: it did not fail
  std::map<std::string, double> metrics;  // by name, those that there are
  std::string slope;                      // [deg], as above
  double wall_time = 0.0;                 // [s]
};

class RecordColumns {
 public:
  // `all`: every cell there is, also those that are not run.
  explicit RecordColumns(const std::vector<Cell>& all);

  const std::vector<std::string>& names() const { return names_; }
  Record settings(const Cell& cell) const;  // what is known before it is run
  Record record(const Cell& cell, const CellResult& result) const;  // and after
  bool same_settings(const Record& line,
                     const Cell& cell) const;  // made of the same settings, base and --set

 private:
  std::vector<std::string> names_, varied_;
};

}  // namespace impedraw

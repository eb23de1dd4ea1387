#include "impedraw/study/robustness.h"

#include "impedraw/common/exit_code.h"
#include "impedraw/study/provenance.h"
#include "impedraw/study/robustness_run.h"
#include "impedraw/study/robustness_table.h"

namespace impedraw {

int run_matrix(const std::vector<Cell>& all, const std::vector<Cell>& desired,
               const CellTableOptions& options) {
  const RecordColumns columns(all);
  CellTable table;
  table.name = "robustness";
  table.columns = columns.names();
  table.same = [&](const Record& line, const Cell& cell) {
    return columns.same_settings(line, cell);
  };
  table.measure = [](const Cell& cell, const std::filesystem::path& log) {
    return result_text(run_cell(cell, log));
  };
  table.record = [&](const Cell& cell, const ProcessEnd& end) {
    return columns.record(cell, result_of(end));
  };
  table.page = [&](const Records& records) { return robustness_page(all, records, provenance()); };
  return run_table(table, all, desired, options);
}

int robustness(const CellTableOptions& options) {
  const std::vector<Cell> all = robustness_cells();
  const std::vector<Cell> desired = matching(all, options.only);
  if (!options.list) return run_matrix(all, desired, options);
  print_cells(desired);
  return kFinished;
}

}  // namespace impedraw

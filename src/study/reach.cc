#include "impedraw/study/reach.h"

#include "impedraw/common/exit_code.h"
#include "impedraw/run/run_folder.h"
#include "impedraw/study/provenance.h"
#include "impedraw/study/reach_cells.h"
#include "impedraw/study/reach_page.h"
#include "impedraw/study/reach_run.h"

namespace impedraw {

int run_reach(const std::vector<Cell>& desired, const CellTableOptions& options) {
  const std::filesystem::path folder = table_folder("reach", options), ink = folder / "ink";
  const std::vector<Cell> all = reach_cells();
  const auto ink_file = [&](const Cell& cell) { return ink / (cell.name + ".json"); };
  CellTable table;
  table.name = "reach";
  table.columns = reach_columns();
  table.same = [&](const Record& line, const Cell& cell) {
    return field(line, "settings") == settings_digest(cell) &&
           std::filesystem::exists(ink_file(cell));
  };
  table.measure = [&](const Cell& cell, const std::filesystem::path& log) {
    make_folder(ink);
    return measure_reach(cell, log, ink_file(cell));
  };
  table.record = reach_record;
  table.page = [&](const Records& records) { return reach_page(all, records, provenance()); };
  table.time_limit = 900.0;
  return run_table(table, all, desired, options);
}

int reach(const CellTableOptions& options) {
  const std::vector<Cell> desired = matching(reach_cells(), options.only);
  if (!options.list) return run_reach(desired, options);
  print_cells(desired);
  return kFinished;
}

}  // namespace impedraw

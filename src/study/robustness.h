// ./impedraw robustness: measures the limits of the method cell by cell
// (robustness_cells.h, cell_table.h).
#pragma once

#include <vector>

#include "impedraw/study/cell_table.h"

namespace impedraw {

// The program's exit code: 0 when every cell was run, also where some failed. Throws InputError.
int robustness(const CellTableOptions& options);

// The same for other cells: `all` sets the columns, `desired` is run.
int run_matrix(const std::vector<Cell>& all, const std::vector<Cell>& desired,
               const CellTableOptions& options);

}  // namespace impedraw

// ./impedraw reach: ten drawings on ten canvases. In each combination every stroke must be drawn,
// or named by the pre-flight with a reason. Ink must cover what is promised (reach_run.h).
//
// Beside the table (cell_table.h) the folder gets ink/CELL.json, from which reach.png is drawn.
#pragma once

#include "impedraw/study/cell_table.h"

namespace impedraw {

// The program's exit code: 0 when every combination was run, also where some missed a limit. Throws
// InputError.
int reach(const CellTableOptions& options);

// The same for the cells `desired` of reach_cells().
int run_reach(const std::vector<Cell>& desired, const CellTableOptions& options);

}  // namespace impedraw

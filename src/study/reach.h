// ./impedraw reach: ten drawings on ten canvases. Of each combination every stroke is to be drawn,
// or named by the pre-flight with its reason, and what is promised is to be covered (reach_run.h).
//
// Beside the table (cell_table.h) the folder gets ink/CELL.json, from which reach.png is drawn.
#pragma once

#include "impedraw/study/cell_table.h"

namespace impedraw {

// The program's exit code: 0 when every combination was run, also where some missed a limit. Throws
// InputError.
int reach(const CellTableOptions& options);

// The same of the cells `desired`, as reach_cells() has them.
int run_reach(const std::vector<Cell>& desired, const CellTableOptions& options);

}  // namespace impedraw

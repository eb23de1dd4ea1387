// robustness.md: every cell's ink error and force in a few tables, then each that failed with its
// cause and its command.
#pragma once

#include <string>
#include <vector>

#include "impedraw/study/cell_table.h"

namespace impedraw {

// `records` by the cell's name; a cell without one has not been run, and its entry says so. `made`:
// date and commit (provenance.h).
std::string robustness_page(const std::vector<Cell>& cells, const Records& records,
                            const std::string& made);

}  // namespace impedraw

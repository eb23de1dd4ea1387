// reach.md: the table of ./impedraw reach, what is drawn on what, what is not drawn and why, what
// missed.
#pragma once

#include <string>
#include <vector>

#include "impedraw/study/cell_table.h"

namespace impedraw {

// A combination without a record has not been run, and its entry says so. `made`: date and commit
// (provenance.h).
std::string reach_page(const std::vector<Cell>& cells, const Records& records,
                       const std::string& made);

}  // namespace impedraw

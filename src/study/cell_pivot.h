// Cells as Markdown tables, by the cells' rows and columns.
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "impedraw/study/cell.h"

namespace impedraw {

// The distinct values of key(cell), in the order of the cells.
template <class Key>
std::vector<std::string> in_order(const std::vector<const Cell*>& cells, Key key) {
  std::vector<std::string> values;
  for (const Cell* cell : cells)
    if (std::find(values.begin(), values.end(), key(*cell)) == values.end())
      values.push_back(key(*cell));
  return values;
}

// Each entry is text_of(cell); entries without a cell are empty.
std::string pivot(const std::vector<const Cell*>& cells,
                  const std::function<std::string(const Cell&)>& text_of);

// Two significant digits without an exponent; "–" for an empty text.
std::string short_number(const std::string& text);

}  // namespace impedraw

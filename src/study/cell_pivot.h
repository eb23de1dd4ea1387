// Cells as Markdown tables: a row and a column each, as the cells name them.
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "impedraw/study/cell.h"

namespace impedraw {

// What key(cell) is, each value once, in the order of the cells.
template <class Key>
std::vector<std::string> in_order(const std::vector<const Cell*>& cells, Key key) {
  std::vector<std::string> values;
  for (const Cell* cell : cells)
    if (std::find(values.begin(), values.end(), key(*cell)) == values.end())
      values.push_back(key(*cell));
  return values;
}

// A cell's place reads text_of(cell); where there is none, nothing.
std::string pivot(const std::vector<const Cell*>& cells,
                  const std::function<std::string(const Cell&)>& text_of);

// Two significant digits, and never in powers of ten; "–" for an empty text.
std::string short_number(const std::string& text);

}  // namespace impedraw

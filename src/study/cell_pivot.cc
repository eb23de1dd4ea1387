#include "impedraw/study/cell_pivot.h"

#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

namespace impedraw {

std::string short_number(const std::string& text) {
  if (text.empty()) return "–";
  const double x = std::strtod(text.c_str(), nullptr);
  if (x == 0.0) return "0";
  const int digits = std::clamp(1 - static_cast<int>(std::floor(std::log10(std::abs(x)))), 0, 4);
  return fmt::format("{:.{}f}", x, digits);
}

std::string pivot(const std::vector<const Cell*>& cells,
                  const std::function<std::string(const Cell&)>& text_of) {
  const std::vector<std::string> rows = in_order(cells, [](const Cell& c) { return c.row; });
  const std::vector<std::string> columns = in_order(cells, [](const Cell& c) { return c.column; });
  std::string text = "| |";
  for (const std::string& column : columns) text += " " + column + " |";
  text += "\n|---|";
  for (std::size_t i = 0; i < columns.size(); ++i) text += "---|";
  for (const std::string& row : rows) {
    text += "\n| " + row + " |";
    for (const std::string& column : columns) {
      const auto cell = std::find_if(cells.begin(), cells.end(), [&](const Cell* c) {
        return c->row == row && c->column == column;
      });
      text += cell == cells.end() ? " |" : " " + text_of(**cell) + " |";
    }
  }
  return text + "\n";
}

}  // namespace impedraw

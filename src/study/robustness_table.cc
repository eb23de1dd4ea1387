#include "impedraw/study/robustness_table.h"

#include <cstdlib>

#include <fmt/format.h>

#include "impedraw/study/cell_pivot.h"
#include "impedraw/study/robustness_run.h"

namespace impedraw {

namespace {

// "0.012 / 0.03", "**✗ slow** 0.31 / 1.2", "**✗ refused**"
std::string cell_text(const Cell& cell, const Records& records) {
  const std::string value = cell.value.empty() ? "" : cell.value + ": ";
  const auto it = records.find(cell.name);
  if (it == records.end()) return value + "not run";
  const std::string cause = field(it->second, "cause"), rms = field(it->second, "ink_error_rms");
  std::string text =
      value + (cause.empty() ? "" : "**✗ " + cause.substr(0, cause.find(':')) + "**");
  if (!cause.empty() && !rms.empty()) text += " ";
  if (!rms.empty() || cause.empty()) {
    text += short_number(rms) + " / " + short_number(field(it->second, "force_sd"));
    // What a model error does to the force is in its mean.
    if (const std::string mean = field(it->second, "force_mean");
        cell.group == "switch" && !mean.empty())
      text += fmt::format(" / {:.2f}", std::strtod(mean.c_str(), nullptr));
  }
  return text;
}

}  // namespace

std::string robustness_page(const std::vector<Cell>& cells, const Records& records) {
  std::vector<const Cell*> all, failed;
  std::size_t run = 0;
  for (const Cell& cell : cells) {
    all.push_back(&cell);
    const auto it = records.find(cell.name);
    if (it == records.end()) continue;
    ++run;
    if (field(it->second, "failed") == "1") failed.push_back(&cell);
  }
  const std::string so_far =
      run < cells.size() ? fmt::format(", of which {} have been run", run) : "";
  std::string text = fmt::format(
      "# Robustness\n\n"
      "What `./impedraw robustness` left: {} cells{}, **{} failed**. Each place reads *ink error "
      "RMS [mm] / standard deviation of the "
      "normal force [N]*, in the last table also *its mean [N]* (5 N is asked for).\n\n"
      "**✗** A cell has failed where it was refused (the drawing cannot be planned), stopped, or "
      "took too long; where a stroke has no "
      "ink (missed), under {:.0f} % of the pen-down samples have (contact), over {:.0f} % of the "
      "ink's length lies more than 1 mm from "
      "its target (astray), or its mean speed is under {:.0f} % of the speed asked for (slow). "
      "`robustness.csv` has every setting and "
      "every metric of each cell.\n\n"
      "![Error and force against slope, speed, push, friction and each model "
      "error](robustness.png)\n",
      cells.size(), so_far, failed.size(), 100.0 * kLeastContact, 100.0 * kMostAstray,
      100.0 * kLeastSpeed);
  for (const std::string& table : in_order(all, [](const Cell& c) { return c.table; })) {
    std::vector<const Cell*> in_table;
    for (const Cell* cell : all)
      if (cell->table == table) in_table.push_back(cell);
    text += "\n## " + table + "\n\n" +
            pivot(in_table, [&](const Cell& cell) { return cell_text(cell, records); });
  }
  text += "\n## What failed\n\n";
  if (failed.empty())
    text += run == cells.size() ? "Nothing.\n" : "Nothing of what has been run.\n";
  for (const Cell* cell : failed)
    text += fmt::format("- `{}`: {}\n  `{}`\n", cell->name, field(records.at(cell->name), "cause"),
                        cell_command(*cell));
  return text;
}

}  // namespace impedraw

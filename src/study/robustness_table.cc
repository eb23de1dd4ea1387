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

std::string robustness_page(const std::vector<Cell>& cells, const Records& records,
                            const std::string& made) {
  std::vector<const Cell*> all, failed;
  std::size_t run = 0;
  for (const Cell& cell : cells) {
    all.push_back(&cell);
    const auto it = records.find(cell.name);
    if (it == records.end()) continue;
    ++run;
    if (field(it->second, "failed") == "1") failed.push_back(&cell);
  }
  const std::string so_far = run < cells.size() ? fmt::format(", of which {} were run", run) : "";
  std::string text = fmt::format(
      "# Robustness\n\n"
      "`./impedraw robustness`, {}: {} cells{}, **{} failed**. Each entry gives *ink error RMS "
      "[mm] / "
      "standard deviation of the normal force [N]*, and in the last table also the *mean normal "
      "force [N]*. The desired force is 5 N unless the row gives another.\n\n"
      "The matrix of speeds, slopes and forces draws a circle on a leaning plane "
      "(`scenarios/robustness-nominal.yaml`, `robustness-realistic.yaml`). All other cells draw "
      "the standard sine (`bowl-sine`, `bowl-sine-sensor`, `bowl-sine-realistic`, "
      "`bowl-sine-real`, "
      "`bowl-sine-velocity-noise`) and change what their row names. Every cell also sets "
      "`drawing.redraw=false` and `preflight.arm=false`, so "
      "that the law is judged without a second pass, also where the pre-flight would refuse. "
      "`./impedraw robustness --list` prints the command of each "
      "cell.\n\n"
      "**✗** marks a failed cell. A cell fails if it is refused (the drawing cannot be planned), "
      "stops or takes too long; if a stroke has no ink (missed), if less than {:.0f} % of the "
      "pen-down samples have ink (contact), if more than {:.0f} % of the ink's length is over 1 mm "
      "from its target (astray), or if its mean speed is below {:.0f} % of the desired speed "
      "(slow). `robustness.csv` has every setting and metric of each cell.\n\n"
      "![Error and force against slope, speed, force, friction and each model "
      "error](robustness.png)\n",
      made, cells.size(), so_far, failed.size(), 100.0 * kLeastContact, 100.0 * kMostAstray,
      100.0 * kLeastSpeed);
  for (const std::string& table : in_order(all, [](const Cell& c) { return c.table; })) {
    std::vector<const Cell*> in_table;
    for (const Cell* cell : all)
      if (cell->table == table) in_table.push_back(cell);
    text += "\n## " + table + "\n\n" +
            pivot(in_table, [&](const Cell& cell) { return cell_text(cell, records); });
  }
  text += "\n## Failed cells\n\n";
  if (failed.empty()) text += run == cells.size() ? "None.\n" : "None of those that were run.\n";
  for (const Cell* cell : failed)
    text += fmt::format("- `{}`: {}\n  `{}`\n", cell->name, field(records.at(cell->name), "cause"),
                        cell_command(*cell));
  return text;
}

}  // namespace impedraw

#include "impedraw/study/reach_page.h"

#include <cstdlib>
#include <functional>

#include <fmt/format.h>

#include "impedraw/study/cell_pivot.h"
#include "impedraw/study/reach_cells.h"
#include "impedraw/study/reach_run.h"

namespace impedraw {

namespace {

double number(const Record& r, const char* name) {
  return std::strtod(field(r, name).c_str(), nullptr);
}

// "0.012 / 1.000", "**✗** 0.012 / 0.983"
std::string figures(const Record& r) {
  const std::string mark = field(r, "failed") == "1" ? "**✗** " : "";
  if (field(r, "coverage").empty()) return mark + field(r, "verdict");
  return fmt::format("{}{} / {:.4f}", mark, short_number(field(r, "rms_to_45")),
                     number(r, "coverage"));
}

// "1253 mm", "640 of 1253 mm"
std::string share(const Record& r) {
  if (field(r, "asked").empty()) return "–";
  if (field(r, "reasons").empty()) return fmt::format("{:.0f} mm", number(r, "asked"));
  return fmt::format("**{:.0f}** of {:.0f} mm", number(r, "promised"), number(r, "asked"));
}

}  // namespace

std::string reach_page(const std::vector<Cell>& cells, const Records& records,
                       const std::string& date) {
  std::vector<const Cell*> all;
  std::size_t failed = 0, parts = 0;
  double promised = 0.0, asked = 0.0, time = 0.0;
  for (const Cell& cell : cells) {
    all.push_back(&cell);
    const auto it = records.find(cell.name);
    if (it == records.end()) continue;
    failed += field(it->second, "failed") == "1";
    parts += static_cast<std::size_t>(number(it->second, "parts"));
    promised += number(it->second, "promised");
    asked += number(it->second, "asked");
    time += number(it->second, "simulated_time");
  }
  const auto text_of = [&](const std::function<std::string(const Record&)>& text) {
    return [&records, text](const Cell& cell) {
      const auto it = records.find(cell.name);
      return it == records.end() ? std::string("not run") : text(it->second);
    };
  };
  std::string text = fmt::format(
      "# Reach\n\n`./impedraw reach`, {}: ten drawings on ten canvases, {} of {} combinations run, "
      "**{} missed a limit**. Of {:.1f} m "
      "asked for, {:.1f} m in {} parts were promised, and {:.0f} s simulated; the rest was named "
      "beforehand, each part with its reason.\n\n"
      "Limits: every stroke is drawn, or named by the pre-flight with its reason; coverage at "
      "least {} of what was promised; ink error at "
      "most {} mm, root mean square where the canvas leans by less than {:.0f}° from the drawing "
      "axis; no crash. `reach.csv` has the rest "
      "of the figures of each combination; `./impedraw reach --list` the command that draws it "
      "alone.\n\n"
      "![Each drawing on each canvas: ink, and what could not be drawn](reach.png)\n\n",
      date, records.size(), cells.size(), failed, 1e-3 * asked, 1e-3 * promised, parts, time,
      kLeastCoverage, kMostInkError, kGentleSlope);
  text += "## Ink error [mm] / coverage\n\n" + pivot(all, text_of(figures));
  text +=
      "\n## Promised\n\nLength in the drawing plane that the pre-flight promised; bold where that "
      "is not all of it.\n\n";
  text += pivot(all, text_of(share));

  text += "\n## Drawings\n\n| | what, and where it comes from |\n|---|---|\n";
  for (const ReachDrawing& d : reach_drawings())
    text += fmt::format("| `{}` | {} |\n", d.name, d.source);
  text += "\n## Canvases\n\n| | what, and where it comes from |\n|---|---|\n";
  for (const ReachCanvas& c : reach_canvases())
    text += fmt::format("| `{}` | {}: `scenarios/reach-{}.yaml` |\n", c.name, c.source, c.name);

  text +=
      "\n## What is not drawn, and why\n\nParts of strokes by reason. `./impedraw plan` with the "
      "scenario and the "
      "drawing names them one by one.\n\n";
  std::string undrawn, missed;
  for (const Cell& cell : cells) {
    const auto it = records.find(cell.name);
    if (it == records.end()) continue;
    const Record& r = it->second;
    if (const std::string reasons = field(r, "reasons"); !reasons.empty())
      undrawn +=
          fmt::format("| `{}` | {:.0f} | {} |\n", cell.name, number(r, "undrawable"), reasons);
    if (field(r, "failed") == "1")
      missed += fmt::format("- `{}`, {}: {}\n  `{}`\n", cell.name, field(r, "verdict"),
                            field(r, "cause"), cell_command(cell));
  }
  text += undrawn.empty() ? "Nothing: all is drawn.\n"
                          : "| | [mm] | parts by reason |\n|---|---|---|\n" + undrawn;
  return text + "\n## What missed\n\n" + (missed.empty() ? "Nothing.\n" : missed);
}

}  // namespace impedraw

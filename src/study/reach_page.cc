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
                       const std::string& made) {
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
      "# Reach\n\n`./impedraw reach`, {}: ten drawings on ten canvases. {} of {} combinations were "
      "run, and **{} missed a limit**. The pre-flight promised {:.1f} m of the {:.1f} m asked for, "
      "in "
      "{} parts, and named the rest with its reason. The runs took {:.0f} s of simulated time.\n\n"
      "A combination meets its limits if every stroke is drawn or named by the pre-flight, the "
      "coverage of the promised length is at least {}, the ink error is at most {} mm RMS where "
      "the "
      "canvas leans by less than {:.0f}° from the drawing axis, and the program does not crash. "
      "`reach.csv` has the other figures of each combination. `./impedraw reach --list` prints the "
      "command that draws it alone.\n\n"
      "![Each drawing on each canvas: ink, and what could not be drawn](reach.png)\n\n",
      made, records.size(), cells.size(), failed, 1e-3 * promised, 1e-3 * asked, parts, time,
      kLeastCoverage, kMostInkError, kGentleSlope);
  text += "## Ink error [mm] / coverage\n\n" + pivot(all, text_of(figures));
  text +=
      "\n## Promised length\n\nLength in the drawing plane that the pre-flight promised. Bold: "
      "less than "
      "asked for.\n\n";
  text += pivot(all, text_of(share));

  text += "\n## Drawings\n\n| | description and source |\n|---|---|\n";
  for (const ReachDrawing& d : reach_drawings())
    text += fmt::format("| `{}` | {} |\n", d.name, d.source);
  text += "\n## Canvases\n\n| | description and source |\n|---|---|\n";
  for (const ReachCanvas& c : reach_canvases())
    text += fmt::format("| `{}` | {}: `scenarios/reach-{}.yaml` |\n", c.name, c.source, c.name);

  text +=
      "\n## Parts that are not drawn\n\nParts of strokes by reason. `./impedraw plan` with "
      "scenario and "
      "drawing lists them one by one.\n\n";
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
  text += undrawn.empty() ? "None.\n" : "| | [mm] | parts by reason |\n|---|---|---|\n" + undrawn;
  return text + "\n## Missed limits\n\n" + (missed.empty() ? "None.\n" : missed);
}

}  // namespace impedraw

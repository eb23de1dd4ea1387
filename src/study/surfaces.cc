#include "impedraw/study/surfaces.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/common/exit_code.h"
#include "impedraw/log/run_data.h"
#include "impedraw/metrics/metrics.h"
#include "impedraw/planning/stroke_ruler.h"
#include "impedraw/study/cell_pivot.h"
#include "impedraw/study/provenance.h"
#include "impedraw/study/reach_run.h"
#include "impedraw/terminal/clock.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;

constexpr const char* kBase = "scenarios/surfaces.yaml";
constexpr std::array kFigures = {
    "coverage",   "contact_fraction", "ink_error_rms",   "ink_error_max", "force_mean",
    "force_sd",   "force_peak",       "touchdown_peak",  "tilt_mean",     "normal_error_mean",
    "speed_mean", "draw_time",        "time_scale_mean", "strokes_missed"};

double number(const Record& record, const std::string& name) {
  const std::string text = field(record, name);
  return text.empty() ? std::nan("") : std::strtod(text.c_str(), nullptr);
}

// Terrain that the cameras resolve.
bool is_gentle(const Cell& cell) {
  const Scenario s = cell_scenario(cell);
  return s.canvas.kind == CanvasKind::rough && s.canvas.rough.form == RoughForm::fractal &&
         s.canvas.rough.wavelength >= 8e-3 && s.canvas.rough.slope_deg <= 20.0;
}

std::string page(const std::vector<Cell>& cells, const Records& records) {
  std::vector<const Cell*> all;
  for (const Cell& cell : cells) all.push_back(&cell);
  std::string text = fmt::format(
      "# Surfaces\n\n`./impedraw robustness --part surfaces`, {}: {} cells of "
      "`scenarios/surfaces.csv`. Each entry gives *ink error RMS [mm] / standard deviation of the "
      "normal force [N] / mean speed [mm/s] / share of the length promised*. **✗** marks a cell "
      "that stopped or missed a limit; the last table says which.\n",
      provenance(), records.size());
  std::string failed;
  for (const std::string& table : in_order(all, [](const Cell& c) { return c.table; })) {
    std::vector<const Cell*> in_table;
    double asked = 0.0, promised = 0.0;
    for (const Cell* cell : all) {
      if (cell->table != table) continue;
      in_table.push_back(cell);
      const auto it = records.find(cell->name);
      if (it == records.end()) continue;
      asked += std::max(0.0, number(it->second, "asked"));
      promised += std::max(0.0, number(it->second, "promised"));
      if (field(it->second, "failed") == "1")
        failed += fmt::format("- `{}`: {}\n  `{}`\n", cell->name, field(it->second, "cause"),
                              cell_command(*cell));
    }
    text += fmt::format("\n## {}\n\n{:.0f} % of the length is promised.\n\n", table,
                        asked > 0.0 ? 100.0 * promised / asked : 0.0);
    text += pivot(in_table, [&](const Cell& cell) -> std::string {
      const auto it = records.find(cell.name);
      if (it == records.end()) return "not run";
      const Record& r = it->second;
      const double share = number(r, "promised") / number(r, "asked");
      return fmt::format("{}{} / {} / {} / {}", field(r, "failed") == "1" ? "**✗** " : "",
                         short_number(field(r, "ink_error_rms")),
                         short_number(field(r, "force_sd")), short_number(field(r, "speed_mean")),
                         std::isfinite(share) ? fmt::format("{:.2f}", share) : "–");
    });
  }
  return text + "\n## Failed cells\n\n" + (failed.empty() ? "None.\n" : failed);
}

}  // namespace

std::vector<Cell> surface_cells() {
  const fs::path file = fs::path(IMPEDRAW_ROOT) / "scenarios/surfaces.csv";
  std::vector<Cell> cells;
  for (const Record& line : read_csv(file)) {
    Cell cell;
    cell.name = field(line, "cell");
    cell.group = cell.table = field(line, "kind");
    cell.column = field(line, "drawing");
    const std::string suffix = "-" + cell.column;
    if (!cell.name.ends_with(suffix))
      throw InputError(fmt::format("{}: cell {} does not end in its drawing, {}", file.string(),
                                   cell.name, cell.column));
    cell.row = cell.name.substr(0, cell.name.size() - suffix.size());
    cell.base = kBase;
    if (cell.column == "text")
      cell.assignments.emplace_back("drawing.text.text=Hello");
    else
      cell.svg = "artwork/" + cell.column + ".svg";
    std::istringstream settings(field(line, "set"));
    for (std::string one; std::getline(settings, one, ';');) {
      one.erase(0, one.find_first_not_of(' '));
      if (!one.empty()) cell.assignments.push_back(one);
    }
    cells.push_back(std::move(cell));
  }
  return cells;
}

std::string missed_limits(const Cell& cell, const Record& r) {
  std::string missed;
  const auto miss = [&](const std::string& what) { missed += (missed.empty() ? "" : ", ") + what; };
  const auto least = [&](const char* name, double limit) {
    if (!(number(r, name) >= limit))
      miss(fmt::format("{} {} below {}", name, field(r, name), limit));
  };
  const auto most = [&](const char* name, double limit) {
    if (!(number(r, name) <= limit))
      miss(fmt::format("{} {} above {}", name, field(r, name), limit));
  };
  most("unnamed_mm", kMostUnnamed);
  if (!(number(r, "promised") > 0.0)) return missed;
  const bool gentle = is_gentle(cell);
  least("coverage", 0.98);
  least("contact_fraction", 0.99);
  most("touchdown_peak", 8.0);
  most("force_sd", gentle ? 0.5 : 1.5);
  if (gentle) most("ink_error_rms", 0.2);
  least("speed_mean", 15.0);
  return missed;
}

std::string measure_surface(const Cell& cell, const fs::path& log) {
  Record r;
  const auto start = Clock::now();
  try {
    Places places;
    Experiment e = prepare(cell_scenario(cell, &places), places, Unreachable::tell);
    r["asked"] = fmt::format("{:.1f}", 1e3 * plane_length(e.artwork.strokes));
    r["promised"] = fmt::format("{:.1f}", 1e3 * plane_length(e.plan.strokes));
    r["unnamed_mm"] = fmt::format("{:.2f}", unnamed_mm(e));
    if (!e.plan.strokes.empty()) {
      const RunOutcome outcome = run(e, log, seconds_since(start));
      if (outcome.end != RunEnd::finished) r["stopped"] = outcome.cause;
      const Metrics metrics = compute_metrics(read_run(log));
      for (const MetricDefinition& d : metric_definitions())
        if (const auto& value = (metrics.*d.member).value())
          r[d.name] = fmt::format("{:.6g}", *value);
    }
  } catch (const std::exception& error) {
    r["stopped"] = within_tree(error.what());
  }
  std::error_code ignored;
  fs::remove(log, ignored);
  return nlohmann::json(r).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Record surface_record(const Cell& cell, const ProcessEnd& end) {
  Record r;
  if (end.cause.empty()) r = nlohmann::json::parse(end.text).get<Record>();
  r["cell"] = cell.name;
  r["kind"] = cell.group;
  r["drawing"] = cell.column;
  r["settings"] = settings_digest(cell);
  r["cause"] = !end.cause.empty()             ? end.cause
               : !field(r, "stopped").empty() ? "stopped: " + field(r, "stopped")
                                              : missed_limits(cell, r);
  r["failed"] = r["cause"].empty() ? "0" : "1";
  r["wall_time"] = fmt::format("{:.2f}", end.wall_time);
  return r;
}

int surfaces(const CellTableOptions& options) {
  const std::vector<Cell> all = surface_cells();
  const std::vector<Cell> desired = matching(all, options.only);
  if (options.list) {
    print_cells(desired);
    return kFinished;
  }
  CellTable table;
  table.name = "surfaces";
  table.columns = {"cell",  "kind",  "drawing",  "settings",  "failed",
                   "cause", "asked", "promised", "unnamed_mm"};
  table.columns.insert(table.columns.end(), kFigures.begin(), kFigures.end());
  table.columns.emplace_back("wall_time");
  table.same = [](const Record& line, const Cell& cell) {
    return field(line, "settings") == settings_digest(cell);
  };
  table.measure = measure_surface;
  table.record = surface_record;
  table.page = [&](const Records& records) { return page(all, records); };
  table.picture = false;
  table.time_limit = 900.0;
  return run_table(table, all, desired, options);
}

}  // namespace impedraw

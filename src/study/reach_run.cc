#include "impedraw/study/reach_run.h"

#include <cmath>
#include <cstdint>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"
#include "impedraw/log/run_data.h"
#include "impedraw/metrics/metrics.h"
#include "impedraw/study/reach_picture.h"
#include "impedraw/terminal/clock.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;

void put(Record* record, const char* name, const Metric& metric) {
  if (metric.value()) (*record)[name] = fmt::format("{:.6g}", *metric.value());
}

// What the pre-flight said.
Record promise_record(const Experiment& e) {
  Record r;
  std::map<std::string, int> reasons;
  double undrawable = 0.0;
  for (const Finding& f : e.plan.preflight.findings) {
    ++reasons[name_of(f.problem)];
    undrawable += 1e3 * f.part.length();
  }
  for (const auto& [name, count] : reasons)
    r["reasons"] += fmt::format("{}{} {}", r["reasons"].empty() ? "" : "; ", name, count);
  const std::vector<PlacedStroke>& asked = e.artwork.strokes;
  r["strokes"] = std::to_string(asked.size());
  r["asked"] = fmt::format("{:.1f}", 1e3 * plane_length(asked));
  r["parts"] = std::to_string(e.plan.strokes.size());
  r["promised"] = fmt::format("{:.1f}", 1e3 * plane_length(e.plan.strokes));
  r["undrawable"] = fmt::format("{:.1f}", undrawable);
  r["unnamed"] = fmt::format("{:.2f}", unnamed_mm(e));
  r["planned_time"] = fmt::format("{:.2f}", e.plan.path.duration());
  return r;
}

void judge(Record* r, const RunOutcome& outcome) {
  std::vector<std::string> missed;
  const auto number = [&](const char* name) {
    return field(*r, name).empty() ? std::nan("") : std::stod(field(*r, name));
  };
  if (number("unnamed") > kMostUnnamed)
    missed.push_back(fmt::format("{} mm neither promised nor named", field(*r, "unnamed")));
  if (!(number("strokes_missed") == 0.0))
    missed.push_back(field(*r, "strokes_missed") + " strokes without ink");
  if (!(number("coverage") >= kLeastCoverage))
    missed.push_back("coverage " + field(*r, "coverage"));
  if (number("rms_to_45") > kMostInkError)
    missed.push_back(fmt::format("ink error {} mm", field(*r, "rms_to_45")));
  if (outcome.end != RunEnd::finished) {
    (*r)["verdict"] = "stopped";
    (*r)["cause"] = outcome.cause;
  } else {
    (*r)["verdict"] = missed.empty() ? "met" : "missed";
    for (const std::string& miss : missed)
      (*r)["cause"] += ((*r)["cause"].empty() ? "" : ", ") + miss;
  }
}

Record drawn_record(Experiment& e, const fs::path& log, double start_up, const fs::path& ink_file) {
  Record r = promise_record(e);
  if (e.plan.strokes.empty()) {
    const bool named = unnamed_mm(e) <= kMostUnnamed;
    r["verdict"] = named ? "nothing" : "missed";
    if (!named) r["cause"] = fmt::format("{} mm neither promised nor named", r["unnamed"]);
    write_reach_picture(e, nullptr, nullptr, ink_file);
    return r;
  }
  const RunOutcome outcome = run(e, log, start_up);
  const RunData data = read_run(log);
  const InkMatch drawn = match_ink(data);
  const Metrics metrics = compute_metrics(data, drawn);
  put(&r, "coverage", metrics.coverage);
  put(&r, "rms", metrics.ink_error_rms);
  put(&r, "contact_fraction", metrics.contact_fraction);
  put(&r, "strokes_missed", metrics.strokes_missed);
  const double gentle = gentle_error_mm(e, data, drawn, kGentleSlope);
  if (std::isfinite(gentle)) r["rms_to_45"] = fmt::format("{:.6g}", gentle);
  r["redrawn"] = std::to_string(outcome.drawn_again.size());
  r["lacking"] = std::to_string(outcome.lacking.size());
  r["simulated_time"] = fmt::format("{:.2f}", outcome.simulated);
  judge(&r, outcome);
  write_reach_picture(e, &data, &drawn, ink_file);
  return r;
}

}  // namespace

const std::vector<std::string>& reach_columns() {
  static const std::vector<std::string> columns = {"cell",
                                                   "drawing",
                                                   "canvas",
                                                   "base",
                                                   "svg",
                                                   "set",
                                                   "settings",
                                                   "verdict",
                                                   "failed",
                                                   "cause",
                                                   "strokes",
                                                   "parts",
                                                   "asked",
                                                   "promised",
                                                   "undrawable",
                                                   "unnamed",
                                                   "reasons",
                                                   "coverage",
                                                   "rms_to_45",
                                                   "rms",
                                                   "contact_fraction",
                                                   "strokes_missed",
                                                   "redrawn",
                                                   "lacking",
                                                   "planned_time",
                                                   "simulated_time",
                                                   "wall_time"};
  return columns;
}

std::string settings_digest(const Cell& cell) {
  const Scenario scenario = cell_scenario(cell);
  std::string text;
  for (const auto& [name, value] : flat_settings(scenario))
    text += name + "=" + within_tree(value) + "\n";
  for (const fs::path& file : {scenario.drawing.svg, scenario.canvas.mesh.file}) {
    if (!file.empty()) text += InputFile(file).read(std::string::npos);
  }
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return fmt::format("{:016x}", hash);
}

double unnamed_mm(const Experiment& e) {
  std::vector<StrokePart> told;
  for (StrokePart part : e.plan.preflight.drawable) {
    part.stroke = e.plan.source[static_cast<std::size_t>(part.stroke)];
    told.push_back(part);
  }
  for (const Finding& f : e.plan.preflight.findings) told.push_back(f.part);
  double sum = 0.0;
  for (const StrokePart& part : rest_of(e.artwork.strokes, told)) sum += 1e3 * part.length();
  return sum;
}

double gentle_error_mm(const Experiment& e, const RunData& run, const InkMatch& drawn,
                       double slope_deg) {
  const double least = std::cos(slope_deg * std::numbers::pi / 180.0);
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < run.rows(); ++i) {
    if (!std::isfinite(drawn.error[i])) continue;
    const auto there = e.scene.canvas->closest(run.contact_point[i], 1e-3);
    if (!there || there->n_W.dot(e.artwork.X_WP.R.col(2)) <= least) continue;
    sum += drawn.error[i] * drawn.error[i];
    ++count;
  }
  return count == 0 ? std::nan("") : 1e3 * std::sqrt(sum / static_cast<double>(count));
}

std::string measure_reach(const Cell& cell, const fs::path& log, const fs::path& ink_file) {
  Record r;
  const auto start = Clock::now();
  try {
    Places places;
    const Scenario scenario = cell_scenario(cell, &places);
    Experiment experiment = prepare(scenario, places, Unreachable::tell);
    r = drawn_record(experiment, log, seconds_since(start), ink_file);
  } catch (const InputError& error) {
    r["verdict"] = "refused";
    r["cause"] = within_tree(error.what());
  } catch (const std::exception& error) {
    r["verdict"] = "error";
    r["cause"] = within_tree(error.what());
  }
  return nlohmann::json(r).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Record reach_record(const Cell& cell, const ProcessEnd& end) {
  Record r;
  if (end.cause.empty()) {
    r = nlohmann::json::parse(end.text).get<Record>();
  } else {
    r["verdict"] = end.cause.substr(0, end.cause.find(':'));
    r["cause"] = end.cause;
  }
  r["cell"] = cell.name;
  r["drawing"] = cell.row;
  r["canvas"] = cell.column;
  r["base"] = cell.base;
  r["svg"] = cell.svg;
  for (const std::string& assignment : cell.assignments)
    r["set"] += (r["set"].empty() ? "" : "; ") + assignment;
  r["settings"] = settings_digest(cell);
  r["failed"] = r["verdict"] == "met" || r["verdict"] == "nothing" ? "0" : "1";
  r["wall_time"] = fmt::format("{:.2f}", end.wall_time);
  return r;
}

}  // namespace impedraw

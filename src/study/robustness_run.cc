#include "impedraw/study/robustness_run.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/log/run_data.h"
#include "impedraw/metrics/metrics.h"
#include "impedraw/run/run.h"
#include "impedraw/terminal/clock.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;

double steepest_slope_deg(const Experiment& e) {
  double least = 1.0;
  for (const Eigen::Vector3d& p_W : e.plan.target.points)
    least = std::min(least, e.scene.canvas->closest(p_W).n_W.z());
  return std::acos(std::clamp(least, -1.0, 1.0)) * 180.0 / std::numbers::pi;
}

std::string failure(const RunOutcome& outcome, const Metrics& metrics, double speed) {
  const double missed = metrics.strokes_missed.or_nan(),
               contact = metrics.contact_fraction.or_nan(), astray = metrics.ink_outside.or_nan();
  const double reached = metrics.speed_mean.or_nan() / (1e3 * speed);
  if (outcome.end != RunEnd::finished) return "stopped: " + outcome.cause;
  if (!(missed == 0.0)) return fmt::format("missed: {:.0f} strokes without ink", missed);
  if (!(contact >= kLeastContact))
    return fmt::format("contact: ink in {:.1f} % of the pen-down samples", 100.0 * contact);
  if (!(astray <= kMostAstray))
    return fmt::format("astray: {:.1f} % of the ink's length over 1 mm from its target",
                       100.0 * astray);
  if (!(reached >= kLeastSpeed))
    return fmt::format("slow: {:.1f} % of the speed asked for", 100.0 * reached);
  return {};
}

}  // namespace

CellResult run_cell(const Cell& cell, const fs::path& log) {
  CellResult result;
  const auto start = Clock::now();
  try {
    Places places;
    const Scenario scenario = cell_scenario(cell, &places);
    Experiment experiment = prepare(scenario, places);
    result.slope = fmt::format("{:.1f}", steepest_slope_deg(experiment));
    const RunOutcome outcome = run(experiment, log, seconds_since(start));
    const Metrics metrics = compute_metrics(read_run(log));
    result.cause = failure(outcome, metrics, experiment.scenario.path.draw_speed);
    for (const MetricDefinition& d : metric_definitions())
      if (const auto& value = (metrics.*d.member).value()) result.metrics[d.name] = *value;
  } catch (const InputError& error) {
    result.cause = "refused: " + within_tree(error.what());
  } catch (const std::exception& error) {
    result.cause = "error: " + within_tree(error.what());
  }
  std::error_code ignored;
  fs::remove(log, ignored);
  result.wall_time = seconds_since(start);
  return result;
}

std::string result_text(const CellResult& result) {
  const nlohmann::json whole = {
      {"cause", result.cause}, {"metrics", result.metrics}, {"slope", result.slope}};
  return whole.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

CellResult result_of(const ProcessEnd& end) {
  CellResult result;
  result.wall_time = end.wall_time;
  result.cause = end.cause;
  if (!end.cause.empty()) return result;
  const nlohmann::json whole = nlohmann::json::parse(end.text);
  result.cause = whole.at("cause").get<std::string>();
  result.metrics = whole.at("metrics").get<std::map<std::string, double>>();
  result.slope = whole.at("slope").get<std::string>();
  return result;
}

}  // namespace impedraw

// Draws and measures a scenario of this repository.
#pragma once

#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "impedraw/experiment/draw_options.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/log/run_data.h"
#include "impedraw/metrics/metrics.h"
#include "impedraw/run/run.h"
#include "run/bounds.h"

namespace impedraw {

struct Figures {
  RunOutcome outcome;
  RunRows run;
  Metrics metrics;
  double operator[](const std::string& name) const {  // NaN: there is none
    for (const MetricDefinition& d : metric_definitions())
      if (d.name == name) return (metrics.*d.member).or_nan();
    throw std::out_of_range("no metric " + name);
  }
};

// `end`: the expected end of the run.
inline Figures draw_scenario(const std::string& name,
                             const std::vector<std::string>& assignments = {},
                             RunEnd end = RunEnd::finished) {
  DrawOptions options;
  options.scenario = "scenarios/" + name + ".yaml";
  options.assignments = assignments;
  Experiment experiment = prepare(resolve(options));
  const std::filesystem::path log = std::filesystem::temp_directory_path() /
                                    ("impedraw_figures_" + std::to_string(getpid()) + ".h5");
  const RunOutcome outcome = run(experiment, log, 0.0);
  EXPECT_EQ(outcome.end, end) << name << ": " << outcome.cause;
  Figures figures{outcome, read_rows(log), compute_metrics(read_run(log))};
  std::filesystem::remove(log);
  return figures;
}

// Draws a run of bounds.json with each of its seeds and checks it. Returns the last run.
inline Figures draw_within_bounds(const std::string& run) {
  const nlohmann::json& entry = bounds().at("runs").at(run);
  Figures figures;
  for (const int seed : entry.at("seeds")) {
    SCOPED_TRACE(run + ", seed " + std::to_string(seed));
    auto assignments = entry.at("set").get<std::vector<std::string>>();
    assignments.push_back("seed=" + std::to_string(seed));
    figures = draw_scenario(entry.at("scenario"), assignments);
    expect_within_bounds(run, [&](const std::string& metric) { return figures[metric.c_str()]; });
  }
  return figures;
}

}  // namespace impedraw

// Draws and measures a scenario of this repository.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "impedraw/experiment/prepare.h"
#include "impedraw/log/run_data.h"
#include "impedraw/metrics/metrics.h"
#include "impedraw/run/simulated_arm.h"
#include "log/run_columns.h"
#include "run/bounds.h"
#include "seeds.h"

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
inline Figures draw_scenario(const Scenario& scenario, RunEnd end = RunEnd::finished) {
  Prepared experiment = prepare(scenario);
  const std::filesystem::path log = std::filesystem::temp_directory_path() /
                                    ("impedraw_figures_" + std::to_string(getpid()) + ".h5");
  const RunOutcome outcome = run(experiment, log, 0.0);
  EXPECT_EQ(outcome.end, end) << scenario.name << ": " << outcome.cause;
  Figures figures{outcome, read_rows(log), compute_metrics(read_run(log))};
  std::filesystem::remove(log);
  return figures;
}

inline Scenario resolve_scenario(const std::string& name,
                                 const std::vector<std::string>& assignments = {}) {
  DrawOptions options;
  options.scenario = "scenarios/" + name + ".yaml";
  options.assignments = assignments;
  return resolve(options);
}

inline Figures draw_scenario(const std::string& name,
                             const std::vector<std::string>& assignments = {},
                             RunEnd end = RunEnd::finished) {
  return draw_scenario(resolve_scenario(name, assignments), end);
}

// Draws a run of bounds.json with its first two seeds, or with all of them under IMPEDRAW_LONG, and
// checks it. Returns the last run.
inline Figures draw_within_bounds(const std::string& run) {
  const nlohmann::json& entry = bounds().at("runs").at(run);
  Figures figures;
  auto runs = entry.at("seeds").get<std::vector<int>>();
  runs.resize(seeds(std::min<unsigned>(2, runs.size()), runs.size()));
  for (const int seed : runs) {
    SCOPED_TRACE(run + ", seed " + std::to_string(seed));
    auto assignments = entry.at("set").get<std::vector<std::string>>();
    assignments.push_back("seed=" + std::to_string(seed));
    figures = draw_scenario(entry.at("scenario"), assignments);
    expect_within_bounds(run, [&](const std::string& metric) { return figures[metric.c_str()]; });
  }
  return figures;
}

// The largest torque rate of any joint between two steps of 1 ms [Nm/s].
inline double torque_rate(const Figures& f) {
  const auto& tau = f.run.joint_torque;
  double most = 0.0;
  for (int i = 1; i < tau.rows(); ++i)
    most = std::max(most, (tau.row(i) - tau.row(i - 1)).cwiseAbs().maxCoeff() / 1e-3);
  return most;
}

}  // namespace impedraw

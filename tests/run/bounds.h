// Bounds of a drawing's figures: tests/run/bounds.json.
//
// Each figure has two bounds. `promised` is the fixed limit [least, most] set by an issue.
// `measured` is the program's result when the table was made. A figure is a regression if its
// distance from its best value exceeds 1.3 times the measured distance plus the resolution at which
// it is quoted.
// `./impedraw figures --bounds` updates the table; explain the reason in the commit.
#pragma once

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace impedraw {

inline const nlohmann::json& bounds() {
  static const nlohmann::json all =
      nlohmann::json::parse(std::ifstream("tests/run/bounds.json"), nullptr, true, true);
  return all;
}

inline constexpr double kRegression = 1.3;

// Largest distance of the figure from its best value that is not a regression.
inline double allowed_deviation(const std::string& run, const std::string& metric) {
  const double best = bounds().at("best").at(metric);
  const double measured = bounds().at("runs").at(run).at("bounds").at(metric).at("measured");
  return kRegression * std::abs(measured - best) + bounds().at("resolution").value(metric, 0.0);
}

// Describes the violated bound; empty if the figure holds.
inline std::vector<std::string> missed_bounds(const std::string& run, const std::string& metric,
                                              double value) {
  std::vector<std::string> missed;
  const double best = bounds().at("best").at(metric);
  const nlohmann::json& bound = bounds().at("runs").at(run).at("bounds").at(metric);
  const nlohmann::json &least = bound.at("promised")[0], &most = bound.at("promised")[1];
  if (!std::isfinite(value)) return {fmt::format("{}: {} could not be computed", run, metric)};
  if (!least.is_null() && value < least.get<double>())
    missed.push_back(fmt::format("{}: {} is {}, promised are {} or more", run, metric, value,
                                 least.get<double>()));
  if (!most.is_null() && value > most.get<double>())
    missed.push_back(fmt::format("{}: {} is {}, promised are {} at most", run, metric, value,
                                 most.get<double>()));
  // A figure better than measured is no regression. A figure that is bad by design, such as the
  // blind pen's tilt, is bounded on the best value's side only.
  if (std::abs(value - best) > allowed_deviation(run, metric))
    missed.push_back(fmt::format("{}: {} is {}, was {} when tests/run/bounds.json was made", run,
                                 metric, value, bound.at("measured").get<double>()));
  return missed;
}

// `figure(metric)` returns the figure of the run.
template <typename Figure>
void expect_within_bounds(const std::string& run, const Figure& figure) {
  for (const auto& [metric, bound] : bounds().at("runs").at(run).at("bounds").items())
    for (const std::string& missed : missed_bounds(run, metric, figure(metric)))
      ADD_FAILURE() << missed;
}

}  // namespace impedraw

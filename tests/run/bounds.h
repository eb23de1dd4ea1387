// What a drawing is compared with: tests/run/bounds.json.
//
// Two bounds for each figure. `promised` is the limit that an issue set, [least, most], and stays.
// `measured` is what the program gave when the table was made; a regression is a figure that is
// further from its best value than 1.3 times what was measured, and than the resolution at which
// the figure is quoted. `./impedraw figures --bounds` measures again: the commit says why.
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

// How far the figure may be from its best value without being a regression.
inline double allowed_deviation(const std::string& run, const std::string& metric) {
  const double best = bounds().at("best").at(metric);
  const double measured = bounds().at("runs").at(run).at("bounds").at(metric).at("measured");
  return kRegression * std::abs(measured - best) + bounds().at("resolution").value(metric, 0.0);
}

// What a figure misses; empty where it holds.
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
  // Better than measured is no regression; and a figure that is meant to be bad, as the blind
  // pen's tilt, is bound from the best value's side alone.
  if (std::abs(value - best) > allowed_deviation(run, metric))
    missed.push_back(fmt::format("{}: {} is {}, was {} when tests/run/bounds.json was made", run,
                                 metric, value, bound.at("measured").get<double>()));
  return missed;
}

// `figure(metric)`: of the run that was drawn.
template <typename Figure>
void expect_within_bounds(const std::string& run, const Figure& figure) {
  for (const auto& [metric, bound] : bounds().at("runs").at(run).at("bounds").items())
    for (const std::string& missed : missed_bounds(run, metric, figure(metric)))
      ADD_FAILURE() << missed;
}

}  // namespace impedraw

// report.html and compare.html: self-contained pages with metrics, pictures and plots over time.
//
// The C++ code computes all data shown. report.py draws the plots (matplotlib) and assembles the
// page.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "impedraw/log/run_data.h"
#include "impedraw/metrics/ink_match.h"
#include "impedraw/metrics/metrics.h"

namespace impedraw {

// Bounds of a metric; either may be absent.
struct MetricLimit {
  std::optional<double> least{}, most{};
};

struct ReportSettings {
  std::string title{};  // empty: the log's attribute `scenario`
  // by metric name; the page shows the limit and whether it is met
  std::map<std::string, MetricLimit> limits{};
  std::filesystem::path python{};  // interpreter with matplotlib; empty: the venv of the build
  // Called now and then while the page is made. What it throws ends the work.
  std::function<void()> check{};
};

// Writes folder/report.html. Shows folder/ink_top.svg, folder/ink_page.svg and folder/scenario.yaml
// if they exist. Throws std::runtime_error with one line if the page cannot be made.
void write_report(const std::filesystem::path& folder, const RunData& run, const InkMatch& drawn,
                  const Metrics& metrics, const ReportSettings& settings = {});

struct ComparedRun {
  std::string name;              // "with perception"
  std::filesystem::path folder;  // holds run.h5
};

// Writes out/compare.html and out/compare.png. They show both runs side by side on equal axes, as
// figures 4 to 6 of the paper (drawn and desired line, normal force, tilt). The page also has their
// metrics in one table. Throws InputError if a log cannot be read, otherwise as write_report().
void write_comparison(const ComparedRun& left, const ComparedRun& right,
                      const std::filesystem::path& out, const ReportSettings& settings = {});

}  // namespace impedraw

// report.html and compare.html: pages that stand alone, with numbers, pictures and plots over time
// inside them.
//
// This side computes everything that is shown; report.py beside it draws the plots (matplotlib) and
// puts the page together.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "impedraw/log/run_data.h"
#include "impedraw/metrics/ink_match.h"
#include "impedraw/metrics/metrics.h"

namespace impedraw {

// What a metric must reach; either may be missing.
struct MetricLimit {
  std::optional<double> least{}, most{};
};

struct ReportSettings {
  std::string title{};  // empty: the log's attribute `scenario`
  // by the metric's name; shown beside the value, with whether it holds
  std::map<std::string, MetricLimit> limits{};
  std::filesystem::path
      python{};  // interpreter with matplotlib; empty: the venv that impedraw was built with
};

// Writes folder/report.html. Shows folder/ink_top.svg, folder/ink_page.svg and folder/scenario.yaml
// where they exist. Throws std::runtime_error with one line when
// the page could not be made.
void write_report(const std::filesystem::path& folder, const RunData& run, const InkMatch& drawn,
                  const Metrics& metrics, const ReportSettings& settings = {});

struct ComparedRun {
  std::string name;              // "with perception"
  std::filesystem::path folder;  // holds run.h5
};

// Writes out/compare.html and out/compare.png: both runs side by side on equal axes, as figures 4
// to 6 of the paper (drawn against desired line, normal force, tilt), and their metrics in one
// table. Throws InputError when a log cannot be read, else as above.
void write_comparison(const ComparedRun& left, const ComparedRun& right,
                      const std::filesystem::path& out, const ReportSettings& settings = {});

}  // namespace impedraw

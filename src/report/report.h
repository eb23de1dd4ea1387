// report.html and compare.html: pages that stand alone, with numbers, pictures and plots over time
// inside them.
//
// This side computes everything that is shown; report.py beside it draws the plots (matplotlib) and
// puts the page together.
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "impedraw/log/run_data.h"
#include "impedraw/metrics/ink_match.h"

namespace impedraw {

struct ReportSettings {
  std::string title{};  // empty: the log's attribute `scenario`
  nlohmann::ordered_json
      // {metric: {"min": a, "max": b}}, either may be missing; shown beside the value, with whether
      // it holds
      limits{};
  std::filesystem::path
      python{};  // interpreter with matplotlib; empty: the venv that impedraw was built with
};

// Writes folder/report.html. Shows folder/ink_top.svg, folder/ink_page.svg and folder/scenario.yaml
// where they exist. `metrics` as of compute_metrics. Throws std::runtime_error with one line when
// the page could not be made.
void write_report(const std::filesystem::path& folder, const RunData& run, const InkMatch& drawn,
                  const nlohmann::ordered_json& metrics, const ReportSettings& settings = {});

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

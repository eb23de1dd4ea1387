// report.html and compare.html: self-contained pages of a run and of two runs compared.
//
// report.html is the page of src/page. Of compare.html, C++ computes all data shown; report.py
// draws the plots (matplotlib) and assembles the page.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "impedraw/log/run_data.h"
#include "impedraw/metrics/ink_match.h"
#include "impedraw/metrics/metrics.h"
#include "impedraw/page/page.h"

namespace impedraw {

// Bounds of a metric; either may be absent.
struct MetricLimit {
  std::optional<double> least{}, most{};
};

struct ReportSettings {
  std::string title{};  // empty: the log's attribute `scenario`
  // by metric name; the page shows the limit and whether it is met
  std::map<std::string, MetricLimit> limits{};
  PageContext page{};  // of report.html: what its log does not hold
  // of compare.html: interpreter with matplotlib; empty: the venv of the build
  std::filesystem::path python{};
};

// Writes folder/report.html from folder/run.h5, of which `run` holds a part. Shows ink_top,
// ink_page (SVG, or PNG where the SVG is large), scenario.yaml and strokes.json of the folder if
// they exist. Throws InputError if the log cannot be read, std::runtime_error with one line if the
// page cannot be written.
void write_report(const std::filesystem::path& folder, const RunData& run, const InkMatch& drawn,
                  const Metrics& metrics, const ReportSettings& settings = {});

struct ComparedRun {
  std::string name;              // "with perception"
  std::filesystem::path folder;  // holds run.h5
};

// Writes out/compare.html and out/compare.png. They show both runs side by side on equal axes, as
// figures 4 to 6 of the paper (drawn and desired line, normal force, tilt). The page also has their
// metrics in one table. Throws InputError if a log cannot be read, std::runtime_error with one line
// if the page cannot be made.
void write_comparison(const ComparedRun& left, const ComparedRun& right,
                      const std::filesystem::path& out, const ReportSettings& settings = {});

}  // namespace impedraw

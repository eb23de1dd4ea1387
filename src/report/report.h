// report.html and compare.html: self-contained pages of a run and of runs compared (src/page).
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

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
  PageContext page{};                        // of report.html: what its log does not hold
  std::function<void()> pictures_written{};  // returns when they are; called before they are read
};

// Writes folder/report.html from folder/run.h5, of which `run` holds a part. Shows ink_top,
// ink_page (SVG, or PNG where the SVG is large), scenario.yaml and strokes.json of the folder if
// they exist. Throws InputError if the log cannot be read, std::runtime_error with one line if the
// page cannot be written.
void write_report(const std::filesystem::path& folder, const RunData& run, const InkMatch& drawn,
                  const Metrics& metrics, const ReportSettings& settings = {});

// Pages show stem.svg, or stem.png where the SVG is large or missing.
bool shows_png(const std::filesystem::path& stem);
std::filesystem::path shown_picture(const std::filesystem::path& stem);

struct ComparedRun {
  std::string name;              // "with perception"
  std::filesystem::path folder;  // holds run.h5
  PageContext page{};            // what its log does not hold
};

// Writes out/compare.html, a page that shows the runs side by side with one camera and one time
// line, or their ink in one scene, with their metrics in one table; and out/compare.png (and .svg),
// which shows two or more runs on equal axes as figures 4 to 6 of the paper (drawn and desired
// line, normal force, tilt). Throws InputError if a log cannot be read, std::runtime_error with one
// line if a file cannot be written.
void write_comparison(const std::vector<ComparedRun>& runs, const std::filesystem::path& out,
                      const ReportSettings& settings = {});

// ./impedraw film: a film or a picture of a finished run, rendered without a screen.
struct FilmOptions {
  std::filesystem::path
      run;  // a folder with report.html, plan.html or compare.html, or such a page
  std::filesystem::path out;      // .webp or .mp4: a film; .png: one picture
  std::string size = "1280x720";  // [px]
  double fps = 25.0;              // frames a second of the film
  double speed = 1.0;             // seconds of the run a second of the film
  std::string view = "free", colour, theme = "light";
  std::string hide;                // parts, separated by commas
  std::optional<double> from, to;  // [s]; default: all; a picture shows `to`
  bool plain = false;              // without legend, state and clock
};

// Hands over to web/film.mjs, which renders the page in headless Chromium and has ffmpeg encode it.
// Returns only by throwing: InputError for an option that is not valid or a page that is missing.
int film(const FilmOptions& options);

}  // namespace impedraw

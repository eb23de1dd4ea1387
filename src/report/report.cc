#include "impedraw/report/report.h"

#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include <fmt/format.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/run_python.h"
#include "impedraw/metrics/metrics.h"
#include "impedraw/report/plot_series.h"

namespace impedraw {
namespace {

using Json = nlohmann::ordered_json;

std::string title_of(const RunData& run, const std::string& given) {
  if (!given.empty()) return given;
  const auto scenario = run.attributes.find("scenario");
  return scenario == run.attributes.end() ? "impedraw" : scenario->second;
}

Json definitions() {
  Json out = Json::array();
  for (const MetricDefinition& d : metric_definitions())
    out.push_back({{"name", d.name}, {"unit", d.unit}, {"meaning", d.meaning}});
  return out;
}

Json limits_json(const std::map<std::string, MetricLimit>& limits) {
  Json out = Json::object();
  for (const auto& [name, limit] : limits) {
    out[name] = Json::object();
    if (limit.least) out[name]["min"] = *limit.least;
    if (limit.most) out[name]["max"] = *limit.most;
  }
  return out;
}

std::string existing(const std::filesystem::path& path) {
  return std::filesystem::exists(path) ? std::filesystem::absolute(path).string() : "";
}

// Runs report.py with the page's data in a temporary JSON file.
void make_page(const Json& page, const std::filesystem::path& out, const ReportSettings& settings) {
  std::string name = (std::filesystem::temp_directory_path() / "impedraw_page_XXXXXX").string();
  const int descriptor = mkstemp(name.data());
  if (descriptor < 0)
    throw std::runtime_error("cannot write " + out.string() +
                             ": no temporary file can be made in " + name);
  close(descriptor);
  // What a log of others holds need not be UTF-8.
  std::ofstream(name) << page.dump(-1, ' ', false, Json::error_handler_t::replace);
  const std::string python = settings.python.empty() ? IMPEDRAW_PYTHON : settings.python.string();
  const PythonEnd end =
      run_python({python, {IMPEDRAW_REPORT_SCRIPT, name}, {}, IMPEDRAW_MATPLOTLIB_FOLDER});
  std::filesystem::remove(name);
  if (end == PythonEnd::not_started)
    throw std::runtime_error(
        fmt::format("cannot write {}: {} does not start", out.string(), python));
  if (end == PythonEnd::failed)
    throw std::runtime_error(fmt::format("cannot write {}: {} failed (its message is above)",
                                         out.string(), IMPEDRAW_REPORT_SCRIPT));
}

}  // namespace

void write_report(const std::filesystem::path& folder, const RunData& run, const InkMatch& drawn,
                  const Metrics& metrics, const ReportSettings& settings) {
  Json page;
  page["kind"] = "run";
  page["out"] = std::filesystem::absolute(folder / "report.html").string();
  page["title"] = title_of(run, settings.title);
  page["attributes"] = run.attributes;
  page["definitions"] = definitions();
  page["metrics"] = metrics_json(metrics);
  page["limits"] = limits_json(settings.limits);
  page["series"] = plot_series(run, drawn);
  page["pictures"] = {existing(folder / "ink_top.svg"), existing(folder / "ink_page.svg")};
  page["scenario"] = existing(folder / "scenario.yaml");
  make_page(page, folder / "report.html", settings);
}

void write_comparison(const ComparedRun& left, const ComparedRun& right,
                      const std::filesystem::path& out, const ReportSettings& settings) {
  Json page;
  page["kind"] = "comparison";
  page["out"] = std::filesystem::absolute(out / "compare.html").string();
  page["picture"] = std::filesystem::absolute(out / "compare.png").string();
  page["definitions"] = definitions();
  page["limits"] = limits_json(settings.limits);
  page["runs"] = Json::array();
  for (const ComparedRun* compared : {&left, &right}) {
    const RunData run = read_run(compared->folder / "run.h5");
    const InkMatch drawn = match_ink(run);
    if (page["runs"].empty()) page["title"] = title_of(run, settings.title);
    Json one;
    one["name"] = compared->name;
    one["metrics"] = metrics_json(compute_metrics(run, drawn));
    one["series"] = plot_series(run, drawn);
    one["scenario"] = existing(compared->folder / "scenario.yaml");
    page["runs"].push_back(one);
  }
  make_page(page, out / "compare.html", settings);
}

}  // namespace impedraw

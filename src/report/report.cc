#include "impedraw/report/report.h"

#include <list>
#include <stdexcept>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/files/durable_file.h"
#include "impedraw/files/run_python.h"
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

// The SVG; the PNG where the SVG is large, or missing.
std::filesystem::path picture_of(const std::filesystem::path& stem) {
  constexpr std::uintmax_t kLargeSvg = 1'500'000;  // [bytes]
  const std::filesystem::path svg = stem.string() + ".svg", png = stem.string() + ".png";
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(svg, error);
  if (!error && size <= kLargeSvg) return svg;
  return std::filesystem::exists(png) ? png : svg;
}

// A file of the page: its name in the folder, and its descriptor in report.py.
struct PageFile {
  const char* key;
  std::filesystem::path path;
  int descriptor;
};

// Runs report.py, which is given the page's data and gives back its files.
void make_page(Json page, const std::vector<PageFile>& wanted, const ReportSettings& settings) {
  const std::string python = settings.python.empty() ? IMPEDRAW_PYTHON : settings.python.string();
  std::list<MemoryFile> made;
  std::vector<ChildFile> files;
  for (const PageFile& file : wanted) {
    page[file.key] = fmt::format("/dev/fd/{}", file.descriptor);
    files.push_back({&made.emplace_back(), file.descriptor});
  }
  // What a log of others holds need not be UTF-8.
  const MemoryFile data(page.dump(-1, ' ', false, Json::error_handler_t::replace));
  files.push_back({&data, 0});
  const int code = run_python({.python = python,
                               .arguments = {IMPEDRAW_REPORT_SCRIPT, "/dev/fd/0"},
                               .files = files,
                               .matplotlib_folder = IMPEDRAW_MATPLOTLIB_FOLDER,
                               .check = settings.page.check});
  const std::string out = wanted.front().path.string();
  if (code < 0)
    throw std::runtime_error(fmt::format("cannot write {}: {} does not start", out, python));
  if (code != 0)
    throw std::runtime_error(fmt::format("cannot write {}: {} failed (its message is above)", out,
                                         IMPEDRAW_REPORT_SCRIPT));
  auto content = made.begin();
  for (const PageFile& file : wanted) write_whole(file.path, (content++)->content());
}

}  // namespace

void write_report(const std::filesystem::path& folder, const RunData& run, const InkMatch& drawn,
                  const Metrics& metrics, const ReportSettings& settings) {
  PageRun page;
  page.title = title_of(run, settings.title);
  page.log = folder / "run.h5";
  page.scenario_file = folder / "scenario.yaml";
  page.strokes_file = folder / "strokes.json";
  page.pictures = {{"Ink against target, seen from above", picture_of(folder / "ink_top")},
                   {"Ink against target, on the page", picture_of(folder / "ink_page")}};
  page.limits = limits_json(settings.limits).dump();
  const PagePayload payload = make_payload(page, run, drawn, metrics, settings.page);
  write_whole(folder / "report.html", page_html(page.title, payload));
}

void write_comparison(const ComparedRun& left, const ComparedRun& right,
                      const std::filesystem::path& out, const ReportSettings& settings) {
  Json page;
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
  make_page(std::move(page),
            {{"out", out / "compare.html", 3}, {"picture", out / "compare.png", 4}}, settings);
}

}  // namespace impedraw

#include "impedraw/report/report.h"

#include <nlohmann/json.hpp>

#include "impedraw/files/durable_file.h"
#include "impedraw/metrics/metrics.h"
#include "impedraw/report/comparison_picture.h"

namespace impedraw {
namespace {

using Json = nlohmann::ordered_json;

std::string title_of(const RunData& run, const std::string& given) {
  const auto scenario = run.attributes.find("scenario");
  const std::string title = !given.empty()                     ? given
                            : scenario == run.attributes.end() ? "impedraw"
                                                               : scenario->second;
  return title + (run.attributes.contains("rehearsal") ? " (rehearsal)" : "");
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

PageRun page_of(const std::filesystem::path& folder, const RunData& run,
                const ReportSettings& settings) {
  PageRun page;
  page.title = title_of(run, settings.title);
  page.log = folder / "run.h5";
  page.scenario_file = folder / "scenario.yaml";
  page.strokes_file = folder / "strokes.json";
  page.pictures = [folder, written = settings.pictures_written]() -> std::vector<PagePicture> {
    if (written) written();
    return {{"Ink against target, seen from above", shown_picture(folder / "ink_top")},
            {"Ink against target, on the page", shown_picture(folder / "ink_page")}};
  };
  page.limits = limits_json(settings.limits).dump();
  return page;
}

}  // namespace

std::filesystem::path shown_picture(const std::filesystem::path& stem) {
  constexpr std::uintmax_t kLargeSvg = 1'500'000;  // [bytes]
  const std::filesystem::path svg = stem.string() + ".svg", png = stem.string() + ".png";
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(svg, error);
  if (!error && size <= kLargeSvg) return svg;
  return std::filesystem::exists(png) ? png : svg;
}

void write_report(const std::filesystem::path& folder, const RunData& run, const InkMatch& drawn,
                  const Metrics& metrics, const ReportSettings& settings) {
  const PageRun page = page_of(folder, run, settings);
  write_whole(folder / "report.html",
              page_html(page.title, {make_payload(page, run, drawn, metrics, settings.page)}));
}

void write_comparison(const std::vector<ComparedRun>& runs, const std::filesystem::path& out,
                      const ReportSettings& settings) {
  std::vector<PagePayload> payloads;
  std::vector<PicturedRun> pictured;
  std::string title;
  for (const ComparedRun& compared : runs) {
    const RunData run = read_run(compared.folder / "run.h5");
    const InkMatch drawn = match_ink(run);
    PageRun page = page_of(compared.folder, run, settings);
    if (title.empty()) title = page.title;
    page.name = compared.name;
    payloads.push_back(make_payload(page, run, drawn, compute_metrics(run, drawn), compared.page));
    pictured.push_back(pictured_run(compared.name, run, drawn));
  }
  write_comparison_picture(title, pictured, out / "compare");
  write_whole(out / "compare.html", page_html(title, payloads));
}

}  // namespace impedraw

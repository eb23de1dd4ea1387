#include "app/results.h"

#include <fstream>

#include <fmt/format.h>

#include "common/errors.h"
#include "report/metrics.h"
#include "report/picture.h"
#include "report/report.h"

namespace impedraw {

void require_run_folder(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  if (!fs::exists(folder)) return;
  if (!fs::is_directory(folder)) throw InputError(fmt::format("--out {}: is a file; a folder is needed", folder.string()));
  if (fs::is_empty(folder) || fs::exists(folder / "scenario.yaml")) return;
  throw InputError(fmt::format("--out {}: holds files but no run; name a new or an empty folder, or one that holds a run", folder.string()));
}

nlohmann::ordered_json write_results(const std::filesystem::path& folder, const Artwork& artwork, const Placement& placement) {
  const RunData run = read_run(folder / "run.h5");
  const Drawn drawn = match_ink(run);
  const nlohmann::ordered_json metrics = compute_metrics(run, drawn);
  std::ofstream(folder / "metrics.json") << metrics.dump(2) << "\n";
  write_ink_top(run, drawn, folder / "ink_top");
  const auto to_page = [&placement](const Eigen::Vector3d& p_W) -> Eigen::Vector2d { return placement.to_page(p_W.head<2>()); };
  write_ink_page(run, drawn, to_page, artwork.page, folder / "ink_page");
  write_report(folder, run, drawn, metrics);
  return metrics;
}

std::string metrics_table(const nlohmann::ordered_json& metrics) {
  std::string text;
  for (const MetricDefinition& m : metric_definitions()) {
    const auto& value = metrics.at(m.name);
    const std::string number = value.is_null() ? "-" : fmt::format("{:.5g}", value.get<double>());
    const std::string unit = std::string_view(m.unit) == "1" ? "" : m.unit;
    text += fmt::format("  {:<20} {:>10} {}\n", m.name, number, unit);
  }
  return text;
}

}  // namespace impedraw

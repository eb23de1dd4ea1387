#include "impedraw/run/results.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/experiment/input_files.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/report/picture.h"
#include "impedraw/report/report.h"
#include "impedraw/settings/settings_doc.h"

namespace impedraw {

namespace {

// What the page shows beside the log.
PageContext page_context(const std::filesystem::path& folder, const Scenario& scenario,
                         const PlacedArtwork& artwork) {
  PageContext page;
  try {
    page.arm = read_arm_shapes(urdf_of(scenario.arm));
  } catch (const InputError&) {
    // The page of an old run whose arm is gone shows the pen alone.
  }
  if (scenario.perception.enabled)
    for (const CameraSettings& c : scenario.perception.cameras)
      page.cameras.push_back({look_at(c.p_WC, c.target_W), c.fov_y_deg, c.width, c.height});
  Scenario now = scenario, initial;
  const std::vector<SettingRow> rows = setting_rows(described(now)),
                                defaults = setting_rows(described(initial));
  for (const SettingRow& row : rows) {
    if (row.group) continue;
    const auto same = std::find_if(defaults.begin(), defaults.end(),
                                   [&row](const SettingRow& d) { return d.name == row.name; });
    page.settings.push_back(
        {row.name, row.initial, same == defaults.end() ? "" : same->initial, row.unit, row.help});
  }
  page.command = fmt::format("./impedraw draw {}", (folder / "scenario.yaml").string());
  page.R_WP = artwork.X_WP.R;
  page.ink_width = scenario.pen.width;
  return page;
}

}  // namespace

Metrics write_results(const std::filesystem::path& folder, const Scenario& scenario,
                      const PlacedArtwork& artwork, const std::function<void()>& check) {
  const auto step = [&check] {
    if (check) check();
  };
  const RunData run = read_run(folder / "run.h5");
  step();
  const InkMatch drawn = match_ink(run);
  step();
  const Metrics metrics = compute_metrics(run, drawn);
  write_whole(folder / "metrics.json", metrics_json(metrics).dump(2) + "\n");
  step();
  PictureSettings picture;
  picture.pen = scenario.pen;
  picture.target_width = 2.6 * scenario.pen.width;
  picture.R_WP = artwork.X_WP.R;
  write_ink_top(run, drawn, folder / "ink_top", picture);
  step();
  const auto to_page = [&placement = artwork.placement, X_PW = artwork.X_WP.inverse()](
                           const Eigen::Vector3d& p_W) -> Eigen::Vector2d {
    return placement.to_page((X_PW * p_W).head<2>());
  };
  write_ink_page(run, drawn, to_page, artwork.shape.target.page, folder / "ink_page", picture);
  step();
  ReportSettings report;
  report.page = page_context(folder, scenario, artwork);
  report.page.check = check;
  write_report(folder, run, drawn, metrics, report);
  return metrics;
}

}  // namespace impedraw

#include "impedraw/run/results.h"

#include <future>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/experiment/page_context.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/report/picture.h"
#include "impedraw/report/report.h"
#include "impedraw/terminal/called.h"
#include "impedraw/terminal/say.h"

namespace impedraw {

Metrics write_results(const std::filesystem::path& folder, const Scenario& scenario,
                      const PlacedArtwork& artwork, const std::function<void()>& check) {
  const auto step = [&check] {
    if (check) check();
  };
  const RunData run = read_run(folder / "run.h5");
  if (run.cut_short)
    say(stderr, "note: {}: is cut short; results are of the run up to {:.2f} s\n",
        (folder / "run.h5").string(), run.time.empty() ? 0.0 : run.time.back());
  step();
  const InkMatch drawn = match_ink(run);
  step();
  const auto to_page = [&placement = artwork.placement, X_PW = artwork.X_WP.inverse()](
                           const Eigen::Vector3d& p_W) -> Eigen::Vector2d {
    return placement.to_page((X_PW * p_W).head<2>());
  };
  // On the second core while metrics and page are made. Does not read the log: HDF5 is not for two
  // threads.
  std::future<void> pictures = std::async(std::launch::async, [&] {
    PictureSettings picture;
    picture.pen = scenario.pen;
    picture.target_width = 2.6 * scenario.pen.width;
    picture.R_WP = artwork.X_WP.R;
    write_ink_top(run, drawn, folder / "ink_top", picture);
    write_ink_page(run, drawn, to_page, artwork.shape.target.page, folder / "ink_page", picture);
  });
  const Metrics metrics = compute_metrics(run, drawn);
  write_whole(folder / "metrics.json", metrics_json(metrics).dump(2) + "\n");
  step();
  ReportSettings report;
  report.page = page_context(scenario, artwork,
                             as_called("./impedraw draw ") + (folder / "scenario.yaml").string());
  report.page.check = check;
  report.pictures_written = [&] {
    pictures.get();
    step();
  };
  write_report(folder, run, drawn, metrics, report);
  return metrics;
}

}  // namespace impedraw

// Writes the folder of a made-up run, or of two compared, to look at pictures and pages:
//   write_made_up_run FOLDER [blind]        write_made_up_run --compare LEFT RIGHT OUT
#include <cstdio>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "impedraw/metrics/metrics.h"
#include "impedraw/report/picture.h"
#include "impedraw/report/report.h"
#include "log/made_up_run.h"

int main(int argc, char** argv) {
  using namespace impedraw;
  if (argc < 2) return 2;
  if (argc == 5) {
    write_comparison({{"with perception", argv[2]}, {"without", argv[3]}}, argv[4]);
    return 0;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  testing::MadeUpSine settings;
  settings.perception = !(argc > 2 && std::string(argv[2]) == "blind");
  RunLog log(folder / "run.h5", testing::sine_header(settings));
  testing::sine_rows(settings, [&](const LogRow& row) { log.append(row); });
  log.close({0.4, 0.25, 0.0});
  const RunData run = read_run(folder / "run.h5");
  const InkMatch drawn = match_ink(run);
  const auto metrics = compute_metrics(run, drawn);
  std::ofstream(folder / "metrics.json") << metrics_json(metrics).dump(2) << "\n";
  std::ofstream(folder / "scenario.yaml") << "seed: 1\nshape: sine\ncanvas: bowl\n";
  ink_top(run, drawn).write(folder / "ink_top");
  const auto to_page = [](const Eigen::Vector3d& p) {
    return Eigen::Vector2d(-1e3 * p.y(), -1e3 * (p.x() - 0.6));
  };
  ink_page(run, drawn, to_page, {}).write(folder / "ink_page");
  write_report(folder, run, drawn, metrics,
               {.limits = {{"ink_error_rms", {.most = 0.04}},
                           {"force_mean", {.least = 4.95, .most = 5.05}}}});
}

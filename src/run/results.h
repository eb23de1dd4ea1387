// The results in a run's folder: metrics, pictures and report, made from run.h5 and scenario.yaml.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/log/log.h"
#include "impedraw/metrics/metrics.h"

namespace impedraw {

// How deep a cutter's groove became, by the truth, place by place along the lines.
//
// d = n·(p_C − p_E) at every step in contact, on a line; the groove is as deep as the cutter has
// been within kBin, in any pass. A place of a promised line that nothing cut has the depth 0.

inline constexpr const char* kGrooveFile = "groove.json";

class GrooveJudge {
 public:
  static constexpr double kBin = 2e-4;  // [m]

  explicit GrooveJudge(const Experiment& experiment);
  void add(const LogRow& row);
  // depth_error_rms, depth_error_max and depth_mean [mm], under "metrics"; null without a line.
  nlohmann::ordered_json results() const;

 private:
  int lines_;                               // of one pass
  double asked_;                            // [m]
  std::vector<std::vector<double>> depth_;  // of each line, at each of its places [m]
};

class Canvas;

// Writes metrics.json, ink_top and ink_page (SVG and PNG) and report.html beside folder/run.h5.
// The pictures are views along the artwork's drawing axis. `check` is called now and then; what it
// throws ends the work. `canvas`: as in compute_metrics. Returns the metrics.
Metrics write_results(const std::filesystem::path& folder, const Scenario& scenario,
                      const PlacedArtwork& artwork, const std::function<void()>& check = {},
                      const Canvas* canvas = nullptr);

// Where an area was covered; what it holds under "metrics" comes first in metrics.json.
inline constexpr const char* kCoverFile = "cover.json";

// The command that draws the run in a folder again.
std::string draw_again(const std::filesystem::path& folder);

}  // namespace impedraw

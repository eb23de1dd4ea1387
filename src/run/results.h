// The results in a run's folder: metrics, pictures and report, made from run.h5 and scenario.yaml.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/log/log.h"
#include "impedraw/metrics/metrics.h"
#include "impedraw/page/page.h"
#include "impedraw/report/picture.h"

namespace impedraw {

class Canvas;

// The parts of results beside the log, which may be made before there is one.
struct Backdrop {
  PageContext page{};
  std::shared_ptr<const Relief> relief{};  // of ink_top; null: made from the log
};

// `canvas`: the log's.
Backdrop backdrop_of(const Scenario& scenario, const PlacedArtwork& artwork,
                     const std::filesystem::path& folder, const TriangleMesh* canvas = nullptr);

// Writes metrics.json, ink_top and ink_page (SVG and PNG) and report.html beside folder/run.h5.
// The pictures are views along the artwork's drawing axis. `check` is called now and then; what it
// throws ends the work. `canvas`: as in compute_metrics. Returns the metrics.
Metrics write_results(const std::filesystem::path& folder, const Scenario& scenario,
                      const PlacedArtwork& artwork, Backdrop backdrop,
                      const std::function<void()>& check = {}, const Canvas* canvas = nullptr);

// For the terminal: the figures of a cutter, a blade or a nozzle whose run is in the folder, in one
// line; empty for another tool.
std::string tool_figures(const std::filesystem::path& folder);

// The file of a covered area; its "metrics" come first in metrics.json.
inline constexpr const char* kCoverFile = "cover.json";

// The command that draws the run in a folder again.
std::string draw_again(const std::filesystem::path& folder);

}  // namespace impedraw

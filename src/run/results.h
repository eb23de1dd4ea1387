// What a run's folder holds beside the log: metrics, pictures, report. All of it made from run.h5
// and scenario.yaml.
#pragma once

#include <filesystem>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/metrics/metrics.h"

namespace impedraw {

// Writes metrics.json, ink_top and ink_page (SVG and PNG) and report.html beside folder/run.h5;
// returns the metrics. The pictures look along the artwork's drawing axis.
Metrics write_results(const std::filesystem::path& folder, const Scenario& scenario,
                      const PlacedArtwork& artwork);

}  // namespace impedraw

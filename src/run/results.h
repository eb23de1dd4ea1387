// What a run's folder holds beside the log: metrics, pictures, report. All of it made from run.h5
// and scenario.yaml.
#pragma once

#include <filesystem>

#include "impedraw/drawing/placement.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/metrics/metrics.h"

namespace impedraw {

// Writes metrics.json, ink_top and ink_page (SVG and PNG) and report.html beside folder/run.h5;
// returns the metrics. X_WP: the drawing frame, along whose z the pictures look.
Metrics write_results(const std::filesystem::path& folder, const Scenario& scenario,
                      const Artwork& artwork, const Placement& placement, const Pose& X_WP);

}  // namespace impedraw

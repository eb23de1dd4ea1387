// What a run's folder holds beside the log: metrics, pictures, report. All of it made from run.h5 and scenario.yaml.
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "app/scenario.h"
#include "drawing/placement.h"

namespace impedraw {

// A folder may be written where it can be made, is empty, or holds a run (a comparison, a robustness.csv) already. Else throws InputError.
// Touches nothing.
void require_run_folder(const std::filesystem::path& folder);
void require_comparison_folder(const std::filesystem::path& folder);
void require_plan_folder(const std::filesystem::path& folder);
void require_table_folder(const std::filesystem::path& folder, const std::string& csv);  // new, empty, or holds a file of that name

void make_folder(const std::filesystem::path& folder);  // InputError where it cannot be made
void write_file(const std::filesystem::path& file, const std::string& text);  // std::runtime_error that says why where it cannot be written

// Writes metrics.json, ink_top and ink_page (SVG and PNG) and report.html beside folder/run.h5; returns the metrics.
// X_WP: the drawing frame, along whose z the pictures look.
nlohmann::ordered_json write_results(const std::filesystem::path& folder, const Scenario& scenario, const Artwork& artwork,
                                     const Placement& placement, const Pose& X_WP);

// The numbers as a table for the terminal.
std::string metrics_table(const nlohmann::ordered_json& metrics);

}  // namespace impedraw

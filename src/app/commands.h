// The program's commands. Each returns the exit code.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "impedraw/common/exit_code.h"
#include "impedraw/experiment/draw_options.h"
#include "impedraw/live/live_view.h"

namespace impedraw {

// With --place auto, moves canvas and drawing to where the arm reaches them best; with --place
// surface, the drawing alone to where it can be drawn. Prints the placement.
Scenario placed(const DrawOptions& options, const Scenario& scenario, const Places& places);

// `table`: prints all metrics, not only how it went.
int draw(const DrawOptions& options, const LiveOptions& live = {}, bool table = false);
// The pre-flight alone, with a picture; kMissed where something cannot be drawn. `suggest`: also
// settings to try.
int plan(const DrawOptions& options, bool as_json, bool suggest);
int preview(const DrawOptions& options);  // a flat picture of the artwork; nothing is checked
int compare(const DrawOptions& options, bool table);  // with and without perception, side by side
// Finished runs, by their folders: leaves compare.html and its picture in `out`.
int compare_finished(const std::vector<std::filesystem::path>& runs,
                     const std::filesystem::path& out);
// Metrics, pictures and report of a run again, from its log.
int report(const std::filesystem::path& folder, bool table);
int calibrate_tool(const DrawOptions& options,
                   int poses);  // mass and centre of mass of the tool, on the simulated arm
// Every setting: for a terminal, as docs/settings.md, or as docs/scenario.schema.json.
enum class SettingsForm { users, all, markdown, json_schema };
int print_settings(SettingsForm form);

}  // namespace impedraw

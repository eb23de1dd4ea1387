// Scenario + Scene → the lines that cover an area: the strokes of an ordinary drawing, which is
// then planned, checked, drawn and judged as one.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/experiment/experiment.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/experiment/scene.h"
#include "impedraw/planning/cover/cover_lines.h"
#include "impedraw/settings/setting_error.h"

namespace impedraw {

struct CoverPlan {
  SurfaceGrid grid;  // of the planner's surface, in P
  CoverWish wish;
  Centres centres;
  CoverLines lines;
  std::vector<std::vector<double>> forces;  // at each point of the lines [N]
  double one_pass = 0.0;                    // dose over force of the lines, once [m]
  double promised_area = 0.0;               // [m²]
  double faint = 0.0;                       // that asks for less than the least force leaves [m²]
  std::vector<std::string> notes;           // what of the area is not covered, one line each
  std::vector<std::string> left_out;        // CoverRegion::left_out
};

// The pad that covers, or a nozzle's jet; nothing for another tool.
std::optional<PadSettings> covering(const Scenario& scenario);

// The scenario as ./impedraw cover completes it: a pad where the tool is not given, 100 mm/s,
// 2 m/s², and normals fitted over at least the footprint. Throws InputError for another tool.
Scenario with_cover_defaults(Scenario scenario, const Places& places);

// Throws InputError where the region is no SVG with areas, lies off the canvas, or the footprint
// fits nowhere in it. Places of P that the planner's surface does not show are not covered.
CoverPlan plan_cover(const Scenario& scenario, const Belief& belief, const Pose& X_WP,
                     const SettingErrors& setting_errors,
                     const std::function<void(double)>& progress = {});

// Lays the lines anew, away from where the arm does not come or crawls, by the drawing of the lines
// as they are. Returns false if it comes everywhere.
bool keep_within_reach(const Scenario& scenario, const PlannedDrawing& drawing, CoverPlan* plan);

// The fate of a part to or off which no way led: other lines have other ways.
enum class Barred { tried_again, lost };

// Leaves out what the drawing of the lines leaves out of them, and promises what is left.
// Returns false if all is drawn.
bool keep_drawn(const Scenario& scenario, const PlannedDrawing& drawing, Barred barred,
                CoverPlan* plan);

// A grid over the same places with the heights of the true canvas, and what a perfect planner
// reaches there: the footprint anywhere in the region where it touches, the slope allows it and the
// arm has a posture, asked every 8 mm.
struct TrueCover {
  SurfaceGrid grid;
  std::vector<char> reachable;
};
TrueCover true_cover(const Scenario& scenario, const Scene& scene, const Pose& X_WP,
                     const CoverPlan& plan);

// The passes as strokes (stroke_file.h, CSV), and the scenario that draws them from that file.
std::string cover_strokes(const CoverPlan& plan, const Scenario& scenario);
Scenario drawing_of_cover(Scenario scenario, const std::filesystem::path& strokes);

}  // namespace impedraw

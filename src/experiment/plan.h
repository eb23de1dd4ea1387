// Stage 3 of an experiment, PlacedArtwork + Scene → Plan: which strokes are drawn, along which
// path, and what ought to come out. Needs no controller; moves nothing.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/experiment/scene.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/preflight/preflight.h"
#include "impedraw/planning/target.h"
#include "impedraw/planning/wrap/wrap.h"
#include "impedraw/settings/setting_error.h"

namespace impedraw {

struct Plan {
  // What the artwork asks for, in P: its strokes, or what a wrap made of them; numbered from 0.
  std::vector<PlacedStroke> requested;
  // Of which stroke of the artwork each of `requested` is: the same number unless a wrap cut it.
  std::vector<int> source;
  std::optional<Wrap> wrap;  // where the drawing is wrapped: on the planner's surface
  JointVector rest_q;        // rest posture of the null space [rad]
  // Of `requested`, whose numbers its drawable parts have; findings have the artwork's.
  Preflight preflight;
  // What is promised: the drawable parts in their order, numbered from 0 as target, path and log
  // do.
  std::vector<PlacedStroke> strokes;
  PathSettings path_settings;      // as planned with; start_hold: a sensor must be tared by then
  TipPath path;                    // of no length where nothing can be drawn
  TargetLine target;               // on the true canvas, in W
  std::vector<std::string> notes;  // what is not drawn; a line each
};

// What becomes of strokes that fail the pre-flight: the drawing is refused; they are left out and
// noted; or left out for the caller to tell, even where nothing is left.
enum class Unreachable { refuse, skip, tell };

// Told what is being done, and about which share of all of the preparation it is.
using PrepareProgress = std::function<void(const char* what, double share)>;

// Throws InputError: one line that names what, where, and what would be valid. The same arguments
// give the same plan. Refusing gives way to the scenario's drawing.skip_unreachable.
Plan make_plan(const Scenario& scenario, const PlacedArtwork& artwork, Scene& scene,
               Unreachable unreachable, const SettingErrors& setting_errors,
               const PrepareProgress& progress = {});

// A path of its own for some of the strokes or parts of them, from where the tip is, at rest, after
// `hold` seconds.
TipPath plan_from(const PathSettings& settings, const SurfaceHeight& surface,
                  const std::vector<PlacedStroke>& strokes, const Eigen::Vector3d& p_WE,
                  const Eigen::Vector3d& n_W, double hold);

}  // namespace impedraw

// Stage 3 of an experiment, PlacedArtwork + Belief → Plan: the strokes to draw and the tip path.
// Needs no controller and moves nothing.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/belief.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/metrics/pens.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/preflight/joint_rates.h"
#include "impedraw/planning/preflight/preflight.h"
#include "impedraw/planning/wrap/wrap.h"
#include "impedraw/settings/setting_error.h"

namespace impedraw {

struct Plan {
  // The artwork's strokes in P, numbered from 0, where the plan wraps or cuts them.
  std::optional<std::vector<PlacedStroke>> laid;
  const std::vector<PlacedStroke>& requested(const PlacedArtwork& artwork) const {
    return laid ? *laid : artwork.strokes;
  }
  // The artwork's stroke number for each of `requested`: the same number unless it was cut.
  std::vector<int> source;
  std::optional<Wrap> wrap;  // onto the planner's surface, if the drawing is wrapped
  JointVector rest_q;        // rest posture of the null space [rad]
  // Drawable parts have the numbers of `requested`; findings have the artwork's.
  Preflight preflight;
  // For a canvas that may move: what fails where it is before it has been watched, with the
  // artwork's numbers. The run checks again where it will be.
  std::vector<Finding> where_it_is;
  // The promised strokes: the drawable parts in order, numbered from 0 as in path and log.
  std::vector<PlacedStroke> strokes;
  DrawingLoad load;            // on the arm, while the pen is down
  PathSettings path_settings;  // the planner's; a sensor must be tared within start_hold
  TipPath path;                // empty if nothing can be drawn
  bool rough = false;          // as is_rough() (plan_notes.h)
  // The pens of `strokes`; none if one pen draws all, whose width does not change with its force.
  std::optional<DrawnPens> pens;
  std::vector<std::string> notes;  // what is not drawn, one line each
};

// Treatment of strokes that fail the pre-flight. refuse: throw. skip: omit and note them; throw if
// nothing is left. tell: omit them, even if nothing is left; the caller reports the findings.
enum class Unreachable { refuse, skip, tell };

// Receives the current step and the approximate fraction of the preparation done.
using PrepareProgress = std::function<void(const char* what, double share)>;

// Throws InputError: one line that names the error, its location and what is valid. Deterministic.
// The scenario's drawing.skip_unreachable turns `refuse` into `skip`.
Plan make_plan(const Scenario& scenario, const PlacedArtwork& artwork, const Belief& belief,
               Unreachable unreachable, const SettingErrors& setting_errors,
               const PrepareProgress& progress = {});

// Limits along strokes that the path alone does not show: of the arm's joints (joint_rates.h), and
// where the surface is rougher than it is known, path.normal_speed (plan_summary.cc).
SpanLimits stroke_limits(const Belief& belief, const Plan& plan, const PathSettings& settings);

// A separate path for some strokes or parts of strokes. It starts at p_WE, at rest, after `hold`
// seconds.
TipPath plan_from(const PathSettings& settings, const SurfaceHeight& surface,
                  const std::vector<PlacedStroke>& strokes, const Eigen::Vector3d& p_WE,
                  const Eigen::Vector3d& n_W, double hold, const SpanLimits& limits = {});

// The pre-flight's settings, completed from the rest of the scenario.
// `seen`: cameras know the surface, so that the pen follows its normal. rest_q: the null space's.
PreflightSettings preflight_settings(const Scenario& scenario, const Pose& X_WP, bool seen,
                                     const JointVector& rest_q);

// By how much the surface, as perceived, may be off [m]; for PreflightSettings::height_error.
// Refers to the belief.
std::function<double(const Eigen::Vector3d&)> height_error(const Belief& belief);

}  // namespace impedraw

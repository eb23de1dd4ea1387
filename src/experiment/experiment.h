// A scenario made ready to run: everything that can be wrong with it is found here, before any file
// is written.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/control/impedance.h"
#include "impedraw/drawing/shapes.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/perception/normals.h"
#include "impedraw/planning/preflight/preflight.h"
#include "impedraw/planning/target.h"
#include "impedraw/planning/wrap/wrap.h"
#include "impedraw/settings/yaml_read.h"
#include "impedraw/simulation/world.h"

namespace impedraw {

struct Experiment {
  Scenario scenario;
  std::vector<std::string>
      notes;      // what was repaired on the way in, what is not drawn; a line each
  Shape artwork;  // as drawn and as desired, on the page
  Placement placement;
  Pose
      // drawing frame, z out of the drawing plane: strokes and the planner's surface are in it
      X_WP;
  std::unique_ptr<Canvas> canvas;  // the truth
  ArmModel arm;
  std::optional<SurfaceEstimator> perception;  // absent: blind
  // The same cloud for the planner, which is to stay clear of its edges: they are told from nearer.
  std::optional<SurfaceEstimator> planning;
  std::vector<PlacedStroke>
      whole;  // what the artwork asks for, laid on the drawing plane; numbered from 0
  std::optional<Wrap> wrap;  // where the drawing is wrapped: on the planner's surface
  std::vector<int>
      // of which stroke of the artwork each of `whole` is: the same number unless a wrap cut it
      source;
  Preflight
      preflight;  // of `whole`, whose numbers its drawable parts have; findings have the artwork's
  std::vector<PlacedStroke>
      // what is promised: the drawable parts in their order, numbered from 0 as target, path and
      // log do
      strokes;
  PathSettings path_settings;   // as planned with
  TipPath path;                 // of no length where nothing can be drawn
  TargetLine target;            // in W
  ImpedanceSettings control;    // completed: rest posture, limits, where the wrench comes from
  WrenchSensorSettings sensor;  // as it is, and
  WrenchEstimatorSettings estimator;  // as it is read; for a WrenchInput
  JointVector start_q;
  double start_hold = 0.0;  // at rest before the first travel; a sensor must be tared by then [s]
  std::unique_ptr<World> world;  // at the start posture

  // The surface that the planner goes by, in P: the cloud, or blind what is known. Refers to the
  // experiment.
  SurfaceHeight surface() const;
};

// What becomes of strokes that fail the pre-flight: the experiment is refused; they are left out
// and noted; or left out for the caller to tell, even where nothing is left.
enum class Unreachable { refuse, skip, tell };

// Throws InputError: one line that names what, where, and what would be valid; `places` say where
// in the YAML or on the command line the settings to setting_errors were given. The same scenario
// gives the same experiment. `progress`: told what is being done, and about which share of all of
// it is.
using PrepareProgress = std::function<void(const char* what, double share)>;
Experiment prepare(const Scenario& scenario, const Places& places = {},
                   Unreachable unreachable = Unreachable::refuse,
                   const PrepareProgress& progress = {});

// X_WP: the drawing plane turned by its tilt about W's origin.
Pose drawing_frame(const DrawingSettings& drawing);

// One line: which stroke of the artwork, which part of it, what, how much, where.
std::string finding_text(const Finding& finding);

// The same for somebody whose drawing is refused because of it. `seen`: by cameras.
std::string refusal_text(const Finding& finding, bool seen);

// A path of its own for some of the strokes or parts of them, from where the tip is, at rest, after
// `hold` seconds.
TipPath plan_from(const Experiment& experiment, const std::vector<PlacedStroke>& strokes,
                  const Eigen::Vector3d& p_WE, const Eigen::Vector3d& n_W, double hold);

// Whether the pen writes, by what the arm itself knows (ink_watch.h): contact state, and measured
// force along the estimated normal [N].
bool writes(const Experiment& experiment, ContactMode mode, double normal_force);

}  // namespace impedraw

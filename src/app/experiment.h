// A scenario made ready to run: everything that can be wrong with it is found here, before any file is written.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/scenario.h"
#include "app/yaml_read.h"
#include "arm/arm_model.h"
#include "canvas/canvas.h"
#include "control/impedance.h"
#include "drawing/shapes.h"
#include "perception/normals.h"
#include "planning/target.h"
#include "simulation/world.h"

namespace impedraw {

struct Experiment {
  Scenario scenario;
  std::vector<std::string> notes;  // what was mended on the way in, a line each
  Shape artwork;                 // as drawn and as wanted, on the page
  Placement placement;
  std::unique_ptr<Canvas> canvas;  // the truth
  ArmModel arm;
  std::optional<SurfaceEstimator> perception;  // absent: blind
  TipPath path;
  TargetLine target;
  ImpedanceSettings control;     // completed: rest posture, limits, where the wrench comes from
  WrenchSensorSettings sensor;   // as it is, and
  WrenchEstimatorSettings estimator;  // as it is read; for a WrenchInput
  JointVector start_q;
  double start_hold = 0.0;       // at rest before the first travel; a sensor must be tared by then [s]
  std::unique_ptr<World> world;  // at the start posture
};

// Throws InputError: one line that names what, where, and what would be valid; `places` say where in the YAML or on the command line the
// settings to blame were given. The same scenario gives the same experiment.
Experiment prepare(const Scenario& scenario, const Places& places = {});

}  // namespace impedraw

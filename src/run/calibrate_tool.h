// Identifies mass and centre of mass of the tool on the wrench sensor. The arm holds the tool still
// in several orientations in the air.
#pragma once

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/driver.h"
#include "impedraw/sensing/tool_identification.h"

namespace impedraw {

struct ToolCalibration {
  ToolIdentification found;
  std::vector<StaticReading> poses;
};

// Moves the driver's arm from the experiment's start posture through `poses` orientations, by
// turning its last three joints about the start posture. Rests `rest` seconds [s] in each and
// averages the reading over the last half. Joint stiffness plus modelled gravity hold the arm: it
// must come to rest, but where matters little. Throws InputError if the experiment has no sensor or
// the joint ranges leave no room.
ToolCalibration calibrate_tool(const Experiment& experiment, Driver& driver, int poses = 8,
                               double rest = 1.0);

}  // namespace impedraw

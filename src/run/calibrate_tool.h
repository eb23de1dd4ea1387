// Finds mass and centre of mass of the tool on the wrench sensor: the arm holds it still in several
// orientations in the air.
#pragma once

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/driver.h"
#include "impedraw/sensing/tool_identification.h"

namespace impedraw {

struct ToolCalibration {
  ToolIdentification found;
  std::vector<StaticReading> poses;
};

// Moves the driver's arm, which stands at the experiment's start posture, through `poses`
// orientations of its last three joints about the start posture, at rest for `rest` seconds each
// [s], of which the last half is averaged. The arm is held by joint stiffness over the believed
// gravity: where it comes to rest matters little, only that it does. Throws InputError where the
// experiment has no sensor, or the joints' ranges leave no room.
ToolCalibration calibrate_tool(Experiment& experiment, Driver& driver, int poses = 8,
                               double rest = 1.0);
// The same with the simulated arm.
ToolCalibration calibrate_tool(Experiment& experiment, int poses = 8, double rest = 1.0);

}  // namespace impedraw

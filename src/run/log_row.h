// What the loop writes into the log (log/log.h).
#pragma once

#include "impedraw/control/impedance.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/log/log.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/run/control_loop.h"
#include "impedraw/run/driver.h"

namespace impedraw {

RunLogHeader make_header(const Experiment& experiment);

// Of a control step: where the arm is, and what the controller makes of it. Where nobody knows the
// truth, the arm's own belief stands for it. Leaves time and step_time alone.
void fill_state(const Experiment& experiment, const ArmState& state, const GroundTruth* truth,
                const PathSample& desired, const ControlLoop& loop, const ImpedanceTorque& out,
                LogRow* row);

// After the command: what then acted on the tip. Without a truth it stays unknown.
void fill_contact(const GroundTruth* truth, LogRow* row);

}  // namespace impedraw

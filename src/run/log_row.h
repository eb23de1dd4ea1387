// Fills the log's header and rows (log/log.h).
#pragma once

#include "impedraw/control/impedance.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/log/log.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/run/control_loop.h"
#include "impedraw/run/driver.h"

namespace impedraw {

RunLogHeader make_header(const Experiment& experiment);

// Fills the arm's state and the controller's output of a control step. Without ground truth, the
// measured state and the arm model replace it. Does not set time and step_time.
void fill_state(const Experiment& experiment, const ArmState& state, const GroundTruth* truth,
                const PathSample& desired, const ControlLoop& loop, const ImpedanceTorque& out,
                LogRow* row);

// Fills the forces on the tip, after the command and fill_state(). Without ground truth: in contact
// the controller's own estimates, that is the measured wrench, the model's tip and the seen normal
// (attribute `contact` of the log says so); without a wrench they are NaN.
void fill_contact(const Experiment& experiment, const GroundTruth* truth, ContactMode mode,
                  LogRow* row);

}  // namespace impedraw

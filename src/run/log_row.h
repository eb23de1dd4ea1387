// Fills the log's header and rows (log/log.h).
#pragma once

#include "impedraw/experiment/experiment.h"
#include "impedraw/log/log.h"
#include "impedraw/run/cycle.h"

namespace impedraw {

RunLogHeader make_header(const Experiment& experiment);

// Fills the arm's state and the controller's output of a cycle, before its torque is commanded.
// Without ground truth, the measured state and the arm model replace it. Does not set step_time and
// time_scale.
void fill_state(const Experiment& experiment, const Cycle& cycle, LogRow* row);

// Fills the forces on the tip, after the command and fill_state(). Without ground truth: in contact
// the controller's own estimates, that is the measured wrench, the model's tip and the seen normal
// (attribute `contact` of the log says so); without a wrench they are NaN.
void fill_contact(const Experiment& experiment, const Cycle& cycle, LogRow* row);

}  // namespace impedraw

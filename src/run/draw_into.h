// One run into a folder, with its results, and what is said of it.
#pragma once

#include <filesystem>
#include <string>

#include "impedraw/metrics/metrics.h"
#include "impedraw/run/run.h"

namespace impedraw {

struct Drawing {
  RunOutcome outcome;
  Metrics metrics;
};

// start_up: seconds it took to prepare. `resume`: go on with the run that the folder holds.
Drawing draw_into(const std::filesystem::path& folder, Experiment& experiment, double start_up,
                  bool resume = false);

// As prepare(), and prepare_plan() that tells what cannot be drawn, with a line on a terminal that
// tells how far it is.
Experiment prepare_visibly(const Scenario& scenario, const Places& places);
PlannedDrawing prepare_plan_visibly(const Scenario& scenario, const Places& places);

void print_notes(const PlannedDrawing& drawing);  // on stderr
std::string met_line(
    const RunOutcome&
        outcome);  // what the controller said of itself while it drew, where that was not all well
std::string ink_lines(
    const Experiment& experiment,
    const RunOutcome& outcome);            // what was drawn again, and what still has no ink
int exit_code(const RunOutcome& outcome);  // says on stderr why it did not finish

}  // namespace impedraw

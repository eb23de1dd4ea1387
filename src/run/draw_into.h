// Runs an experiment into a folder, with results and messages.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "impedraw/metrics/metrics.h"
#include "impedraw/run/run.h"
#include "impedraw/run/run_folder.h"
#include "impedraw/terminal/interrupt.h"

namespace impedraw {

struct Drawing {
  RunOutcome outcome;
  Metrics metrics;
  int signal_code = 0;  // of an interrupted run: 128 + signal; stopped by `watch`: 130
};

// start_up: preparation time [s]. `resume`: continues the run in the folder, or begins it if
// nothing has been drawn yet. `watch`: hooks beside the own ones; a signal ends what is held.
// `held`: of the folder, where the caller has written there already; null: it is locked here.
// Throws InputError if another process writes there, Interrupted if a signal comes while the
// results are made.
//
// make_driver: the arm that draws, given the posture at which it must stand [rad], and what it
// resumes, if it does. simulated_arm.h has the simulated one.
using DriverMaker =
    std::function<std::unique_ptr<Driver>(const JointVector& start_q, const Resumption* resumed)>;
Drawing draw_into(const std::filesystem::path& folder, const Experiment& experiment,
                  const DriverMaker& make_driver, double start_up, bool resume = false,
                  const RunHooks& watch = {}, const FolderLock* held = nullptr);

// Throws Interrupted once a signal has come: the results in the folder are left unfinished. Refers
// to `interrupt`.
std::function<void()> give_up_on(const Interrupt& interrupt, const std::filesystem::path& folder);

void print_notes(const PlannedDrawing& drawing);  // on stderr
// Limits met and bad inputs during the run; empty if there were none.
std::string met_line(const RunOutcome& outcome);
// A line on a bandwidth that noise of the joints' positions lowered: from what, to what,
// and which joint's; empty if it did not.
std::string velocity_line(const Experiment& experiment, const RunOutcome& outcome);
// Lines on the redrawn parts, and on those that still have no ink.
std::string ink_lines(const Experiment& experiment, const RunOutcome& outcome);
int exit_code(const Drawing& drawing);  // prints on stderr why the run did not finish

}  // namespace impedraw

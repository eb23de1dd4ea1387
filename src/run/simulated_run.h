// A drawing that is prepared with its truth, by the simulated arm. Its scenario's pushes and faults
// occur in the first run only, not in a resumed one.
#pragma once

#include <filesystem>

#include "impedraw/experiment/prepare.h"
#include "impedraw/run/draw_into.h"

namespace impedraw {

// As run() of run.h. Throws InputError if the scenario names another arm.
RunOutcome run(Prepared& drawing, const std::filesystem::path& log_file, double start_up,
               const RunHooks& hooks = {}, const Resumption* resumption = nullptr);

// As draw_into() of draw_into.h. make_driver: another arm that draws; empty: the simulated one.
Drawing draw_into(const std::filesystem::path& folder, Prepared& drawing, double start_up,
                  bool resume = false, const RunHooks& watch = {},
                  const DriverMaker& make_driver = {});

// Like prepare(), and prepare_plan() with Unreachable::tell whose control is set up, too, with a
// progress line on a terminal.
Prepared prepare_visibly(const Scenario& scenario, const Places& places);
PreparedPlan prepare_plan_visibly(const Scenario& scenario, const Places& places);

}  // namespace impedraw

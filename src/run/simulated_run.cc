#include "impedraw/run/simulated_run.h"

#include "impedraw/common/errors.h"
#include "impedraw/run/loop_sources.h"
#include "impedraw/run/simulated_arm.h"
#include "impedraw/terminal/progress.h"

namespace impedraw {

namespace {

// Refers to the drawing.
DriverMaker simulated(Prepared& e) {
  if (e.scenario.arm.driver != ArmDriver::sim)
    throw InputError(
        "arm.driver is not sim, and only ./impedraw draw drives such an arm; valid here is sim");
  return [&e](const JointVector& start_q, const Resumption* resumed) {
    return std::make_unique<SimulatedArm>(e, start_q, disturbances_of(e, resumed != nullptr),
                                          resumed ? resumed->time : 0.0);
  };
}

PrepareProgress shown_on(ProgressLine& line) {
  return [&line](const char* what, double share) { line.update(what, share); };
}

}  // namespace

RunOutcome run(Prepared& e, const std::filesystem::path& log_file, double start_up,
               const RunHooks& hooks, const Resumption* resumption) {
  const auto arm = simulated(e)(resumption ? resumption->q : e.belief.start_q, resumption);
  return run(e, *arm, log_file, start_up, hooks, resumption);
}

Drawing draw_into(const std::filesystem::path& folder, Prepared& e, double start_up, bool resume,
                  const RunHooks& watch, const DriverMaker& make_driver) {
  return draw_into(folder, e, make_driver ? make_driver : simulated(e), start_up, resume, watch);
}

Prepared prepare_visibly(const Scenario& scenario, const Places& places) {
  ProgressLine line;
  return prepare(scenario, places, Unreachable::refuse, shown_on(line), nullptr,
                 PlanSummary::beside);
}

PreparedPlan prepare_plan_visibly(const Scenario& scenario, const Places& places) {
  ProgressLine line;
  PreparedPlan drawing = prepare_plan(scenario, places, Unreachable::tell, shown_on(line), nullptr,
                                      PlanSummary::beside);
  control_for(&drawing, places);
  return drawing;
}

}  // namespace impedraw

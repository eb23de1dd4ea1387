// Arms that are not simulated here: making a driver, and the commands `arm check` and `arm hold`.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "impedraw/arm/arm_notes.h"
#include "impedraw/experiment/draw_options.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/live/live_view.h"
#include "impedraw/run/draw_into.h"

namespace impedraw {

// Makes the scenario's driver; empty for the simulated arm. Refers to the experiment.
DriverMaker driver_maker(const Experiment& experiment);

// Throws InputError where the loop would be paused (redrawing, live view, pace) and the arm does
// not wait.
void require_steady_loop(const Scenario& scenario, const LiveOptions& live);

// Says where contact and ink of the run come from, if not from the simulator.
std::string contact_line(const Experiment& experiment);

// Exit code 0 if the arm could be used, kMissed if its statuses come too irregularly.
int check_arm(const DrawOptions& options, double seconds);
int hold_arm(const DrawOptions& options, double seconds);

struct RestingArm {
  JointVector q;  // mean [rad]
  std::unique_ptr<ArmModel> model;
};

// The posture in which an arm that is not simulated here rests for `seconds`; sends nothing. Throws
// std::runtime_error if a joint is faster than `at_rest` [rad/s].
RestingArm posture_at_rest(const DrawOptions& options, double seconds, double at_rest);

// Writes the description of an arm with a pen on its flange, once it is known to be an arm: of one
// of models/arms, or of a vendor's file (plain_urdf.h), on the link `flange` if it is given.
int make_urdf(const std::string& arm, const std::string& flange, const PenOnFlange& pen,
              const std::filesystem::path& out);

}  // namespace impedraw

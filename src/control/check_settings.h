// What can be wrong with the controller's settings whatever the arm does.
#pragma once

#include "impedraw/control/impedance_settings.h"

namespace impedraw {

// Throws InputError: the setting, its value and what would be valid. joints: of the arm, 6 to
// kMaxJoints for a task of six axes.
void check_settings(const ImpedanceSettings& settings, int joints);

}  // namespace impedraw

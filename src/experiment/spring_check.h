// What the law bears of the springs in an arm's joints and of its own torque loop, by what the arm
// is said to have (arm.joint_stiffness, arm.torque_bandwidth).
//
// The torque loop delays what the law commands: the set-up adds that to the loop's delay, against
// which damping is checked (control_setup.cc). The momentum observer takes the springs' motion for a
// disturbance: its bandwidth is lowered to the highest with which the rehearsal of rotor_check.h
// calms down, with springs and loop as they are said to be, and a fifth softer and slower.
#pragma once

#include <string>
#include <vector>

#include "impedraw/experiment/rotor_check.h"

namespace impedraw {

// Lowers setup->impedance.observer.bandwidth as far as that asks for, with a note. Throws InputError
// if no bandwidth does. Nothing happens for an arm without arm.joint_stiffness.
void bear_joint_springs(const Scenario& s, const ArmModel& arm, const Eigen::VectorXd& q,
                        ControlSetup* setup, std::vector<std::string>* notes,
                        const SettingErrors& setting_errors);

}  // namespace impedraw

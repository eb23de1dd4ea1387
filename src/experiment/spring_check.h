// The springs in an arm's joints, and the torque loop of its own, that the law bears, given what
// the arm is said to have (arm.joint_stiffness, arm.torque_bandwidth).
//
// To the law, a joint with a torque loop is a rigid one with what the loop leaves of its rotor,
// K/ω² (arm.rotor_inertia). The loop's lag, 1.4/ω with the link held, is no delay of the torque:
// told as one, it made the force's deviation twice as large. What springs and loop bear is asked of
// a rehearsal (rotor_check.h): the observer's bandwidth is lowered to the highest with which a kick
// dies away, in the air and on the drawing, with springs and loop as they are said to be, with a
// tenth softer springs and a faster loop, and the other way round.
#pragma once

#include "impedraw/experiment/rotor_check.h"

namespace impedraw {

// Lowers setup->impedance.observer.bandwidth as far as that asks for, with a note. Throws
// InputError if no bandwidth does, and for a simulated arm whose motors' side is read while its
// weight bends the springs by more than 0.2 mm at the tip. Else nothing happens for an arm without
// arm.joint_stiffness.
void bear_joint_springs(const Scenario& s, const ArmModel& arm, const Eigen::VectorXd& start_q,
                        const Eigen::VectorXd& q, ControlSetup* setup,
                        std::vector<std::string>* notes, const SettingErrors& setting_errors);

}  // namespace impedraw

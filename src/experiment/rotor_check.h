// The rotor inertia that the arm's model may lack, or have too much of, by what the law bears.
//
// Rehearsal   the set-up's own controller and joint estimator hold the pen on a plane across it:
//               M' v̇ + C v + g = τ(t − delay) + Jᵀ F,     M' = M + diag(unknown)
//             With joint springs, τ(t − delay) is what the arm's torque loop is told.
//             F: of a tip spring, as late as the set-up says. No friction and no noise: what is
//             left of a kick is the loop's own.
// Borne       at most kMostLeft of the joints' motion is left 0.8 s after it
#pragma once

#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/experiment/control_setup.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/settings/setting_error.h"

namespace impedraw {

struct RotorRehearsal {
  ControlSetup setup;  // complete
  JointVector q;       // where the pen is on the drawing [rad]
  double delay = 0.0;  // of the torque [s]
  JointSpringSettings springs{};
  bool lifted = false;  // the pen hangs in the air
};

inline constexpr double kMostLeft = 0.7;

// The share of a kick that is left; more than 1 for a motion that grows. unknown: true rotor
// inertia less the model's, per joint [kg m²].
double kick_left(const RotorRehearsal& rehearsal, ArmModel arm, const Eigen::VectorXd& unknown);

// The greatest unknown rotor inertia, the same on every joint, up to which every kick dies away
// [kg m²]; 0 if the least that is asked about is not borne; at most kMostRotor.
inline constexpr double kMostRotor = 2.0;
double rotor_inertia_borne(const RotorRehearsal& rehearsal, const ArmModel& arm);

// For a simulated arm, throws InputError if its true rotors differ from the model's by more than
// the law bears. A note says what the law bears, for an arm whose rotors differ or are not
// simulated.
void check_rotors(const Scenario& s, const ControlSetup& setup, const ArmModel& arm,
                  const Eigen::VectorXd& q, std::vector<std::string>* notes,
                  const SettingErrors& setting_errors);

}  // namespace impedraw

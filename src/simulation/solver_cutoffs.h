// Counts how often the simulator's solvers stopped before they reached their tolerance.
#pragma once

namespace impedraw {

// Numbers of steps since the simulation began.
struct SolverCutoffs {
  long tip = 0;     // sliding tip: kTipContactSweeps (tip_contact.h)
  long joints = 0;  // joint friction, joint limits and tip together: kJointSweeps
};
inline constexpr int kJointSweeps = 200;

}  // namespace impedraw

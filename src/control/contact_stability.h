// Lower bound on the desired inertia along the normal: stability of the loop of arm, tip spring and
// delayed wrench measurement.
//
// Plant     m v̇ = u + f,  f = k x' + …: tip spring k with damper b, x the penetration
// Control   u = (m/m_d)(−B v + F_push + f_late) − f_late, f_late the force `delay` earlier     (11)
//           v `velocity_steps` old, if the joint velocities come late or from an estimator
// Bound     B + b m_d/m > (1 − m_d/m) k T, to first order in the delay T: the late force removes
//           (1 − m_d/m) k T of damping
// This check is exact instead: the spectral radius of the sampled loop (semi-implicit Euler, whole
// steps of delay) must be below 1. Requires masses, stiffness and dt > 0, and steps ≥ 0.
#pragma once

#include "impedraw/control/impedance_settings.h"

namespace impedraw {

struct ContactLoop {
  double natural_mass;           // m: Λ along the normal [kg]
  double desired_mass;           // m_d [kg]
  double damping;                // B [N s/m]
  double contact_stiffness;      // k [N/m]
  double contact_damping = 0.0;  // b [N s/m]
  double dt;                     // [s]
  int delay_steps;               // age of the measured wrench
  int velocity_steps = 0;        // age of the velocity that is damped
};

double spectral_radius(const ContactLoop& loop);  // < 1: stable

// The lightest desired mass along the normal, from `mass` on, whose loop is stable for every
// natural mass up to stability_check.natural_mass_max [kg]; twice that if none is. `damping`: B
// along the normal with `mass`.
double lightest_stable_mass(double mass, double damping, const ImpedanceSettings& settings);

// The least c ≥ `scale`, up to 1, whose loop is stable with M_d = c Λ along the normal. stiffness:
// K' along n.
double lightest_stable_scale(double scale, double stiffness, const ImpedanceSettings& settings);

// These throw InputError, naming the axis, its value and the least valid value. They use the
// timing, damping ratio and stability_check of the settings.
void check_contact_stability(double desired_mass, double damping,
                             const ImpedanceSettings& settings);
void check_scaled_contact_stability(double scale, double stiffness,
                                    const ImpedanceSettings& settings);
void check_damping_rates(const TipGain& damping, const TipGain& inertia, double dt_and_delay);

}  // namespace impedraw

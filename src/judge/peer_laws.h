// CRISP's Cartesian impedance law, written here from its paper and documentation: a peer that the
// force benchmark compares with. It is not CRISP's code.
//
// Law       τ = Jᵀ ( K e − D J v ) + N ( K_n (q_0 − q) − D_n v ) + C v + g + Jᵀ W
//           e    position and rotation vector to the target pose, each axis clipped
//           N    I − J⁺ J, J⁺ the pseudo-inverse
//           W    target wrench: −F_n n, while the pen should press
//           |Δτ| ≤ max_delta_tau a step, on the whole torque
// Gains     those of default_cartesian_impedance.yaml of crisp_py: 600 N/m, 30 Nm/rad, 60 N s/m,
//           10 Nm s/rad, 5 Nm/rad, D_n = 2 √K_n. Equal along all axes, so that it does not matter
//           that CRISP takes them in the tool's axes.
// Left out  friction feed-forward (its parameters are an FR3's), filters (off), joint-limit torque
// Source    D. San José Pro, O. Hausdörfer, R. Römer, M. Dösch, M. Schuck, A. P. Schoellig,
//           "CRISP – Compliant ROS2 Controllers for Learning-Based Manipulation Policies and
//           Teleoperation", arXiv 2509.06819, 2025.
#pragma once

#include "impedraw/control/arm_terms.h"
#include "impedraw/control/damping.h"
#include "impedraw/control/operational_space.h"
#include "impedraw/control/tip_reference.h"

namespace impedraw {

struct CrispGains {
  double stiffness = 600.0, rotational_stiffness = 30.0;  // K [N/m], [Nm/rad]
  double damping = 60.0, rotational_damping = 10.0;       // D [N s/m], [Nm s/rad]
  double null_stiffness = 5.0;                            // K_n [Nm/rad]
  double clip = 0.1, rotational_clip = 0.5;               // of e [m], [rad]
  double max_delta_tau = 0.5;                             // a step [Nm]
};

class CrispLaw {
 public:
  explicit CrispLaw(const JointVector& q_0, const CrispGains& gains = {});

  // One step. `press`: F_n now [N]. The target's turn about the pen is that of the first step.
  const JointVector& step(const ArmTerms& arm, const TipReference& reference,
                          double press) noexcept;

 private:
  CrispGains gains_;
  JointVector q_0_, tau_;
  Eigen::Matrix3d R_WD_ = Eigen::Matrix3d::Identity();
  bool begun_ = false;
};

// A plain impedance law with feed-forward force, written here: a peer that the force benchmark
// compares with.
//
// Law       F = Λ (V̇_d − J̇v) + J̄ᵀ C v + B (V_d − V) + K e − F_n n
//           τ = Jᵀ F + (I − Jᵀ J̄ᵀ) τ_null + g
// Loop      Λ (V̇ − V̇_d) = B (V_d − V) + K e − F_n n + F_ext: the arm keeps its inertia
// Gains     2000 N/m, 200 Nm/rad, equal along all axes, as an LBR iiwa's own impedance mode
//           proposes; B by double diagonalisation, ζ = 0.7 (damping.h); null space 10 Nm/rad
// Source    N. Hogan, "Impedance control: an approach to manipulation", ASME JDSMC 107(1), 1985;
//           A. Albu-Schäffer, C. Ott, U. Frese, G. Hirzinger, "Cartesian impedance control of
//           redundant robots: recent results with the DLR light-weight-arms", ICRA 2003.

struct FeedforwardGains {
  double stiffness = 2000.0, rotational_stiffness = 200.0;  // K [N/m], [Nm/rad]
  double damping_ratio = 0.7;                               // ζ
  double null_stiffness = 10.0;                             // [Nm/rad]
};

class FeedforwardLaw {
 public:
  explicit FeedforwardLaw(const JointVector& q_0, const FeedforwardGains& gains = {});

  // One step. `press`: F_n now [N]. The turn about the pen is free, but damped.
  const JointVector& step(const ArmTerms& arm, const TipReference& reference,
                          double press) noexcept;

 private:
  FeedforwardGains gains_;
  JointVector q_0_, tau_;
  OperationalSpace space_;
  ModalDamping damping_;
};

}  // namespace impedraw

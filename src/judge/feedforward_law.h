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
#pragma once

#include "impedraw/control/arm_terms.h"
#include "impedraw/control/damping.h"
#include "impedraw/control/operational_space.h"
#include "impedraw/control/tip_reference.h"

namespace impedraw {

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

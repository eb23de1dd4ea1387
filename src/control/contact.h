// The pen's place with respect to the surface: the mode of the contact, and the normal that the
// law follows, which is decided here and nowhere else.
//
// Side      A thin body has two sides a few millimetres apart, and an estimate from points of both
//           may face the other one. One that faces away from the plan by more than 120° is turned.
// Mode      contact_mode.h
// Normal    n   the plan's away from the surface; in approach and contact n_T, the tracked normal
//               (normal_tracker.h), corrected by what is felt (felt_normal.h)
//           n_C normal where the ball of the tip touches: as felt, else n
// Approach  The desired distance to the surface sinks by speed Δt a step to −overtravel. It waits
//           at the tip's distance less `lag` for a tip that is held back, so that no spring winds
//           up, and while the rise is above 10 mm/s. It grows by the rise.
// Rise      u ← u + 80/s Δt (n·(v − v_K) − u) − n·(Δv_K − a_K Δt) in contact on a carrier: the
//           velocity along n that the tip shows the carrier's v_K to lack. The tip is the fastest
//           sensor along n. What v_K changes by beyond a_K Δt, and 0.1 m/s² of it, is a correction
//           of the estimate and no motion: it would throw the pen. In approach u → 0 at 15/s.
//           |u| ≤ 0.4 m/s.
// Force     F_n as the reference gives it, or that of the settings
// Requires  unit normals; one call every dt
#pragma once

#include "impedraw/control/contact_mode.h"
#include "impedraw/control/felt_normal.h"
#include "impedraw/control/normal_tracker.h"
#include "impedraw/control/step_input.h"

namespace impedraw {

// The contact in one step, in W.
struct Contact {
  ContactMode mode = ContactMode::free;
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();    // normal of push, gains and friction
  Eigen::Vector3d n_T = Eigen::Vector3d::UnitZ();  // tracked normal, for the pen's axis
  Eigen::Vector3d w_T = Eigen::Vector3d::Zero();   // its angular velocity [rad/s]
  Eigen::Vector3d n_C = Eigen::Vector3d::UnitZ();  // normal where the tip touches
  Eigen::Vector3d v_K = Eigen::Vector3d::Zero();   // velocity of the carrier at the tip [m/s]
  Eigen::Vector3d v = Eigen::Vector3d::Zero();     // velocity of the tip, less v_K [m/s]
  double force = 0.0;                              // F_n, asked for in contact [N]
  double force_rate = 0.0;                         // its derivative [N/s]
  double rise = 0.0;          // velocity of the surface along n, beyond v_K [m/s]
  double sinking = 0.0;       // desired speed towards the surface, in approach [m/s]
  double off_target = 0.0;    // desired less estimated distance, in approach [m]
  bool surface_lost = false;  // contact is desired, but perception has no surface here

  // Approach and contact: n_T and w_T are the surface's.
  bool on_surface() const noexcept {
    return mode == ContactMode::approach || mode == ContactMode::contact;
  }
};

class SurfaceContact {
 public:
  static constexpr double kOtherSide = -0.5;  // n·n_plan below which an estimate is turned
  static constexpr double kLeastForce = 0.2;  // share of F_n below which no normal is felt
  static constexpr double kRiseRate = 80.0;   // filter rate of the rise [1/s]
  static constexpr double kApproachRiseRate = 15.0;
  static constexpr double kFastestRise = 0.4;  // [m/s]

  // Throws InputError as ContactSettings::validate() does.
  explicit SurfaceContact(const ImpedanceSettings& settings);

  // F_n where the reference gives none [N].
  void retune(double normal_force) noexcept { normal_force_ = normal_force; }
  // One step. The result is overwritten by the next one.
  const Contact& update(const StepInput& in) noexcept;
  void reset() noexcept;  // back to mode free

 private:
  void update_mode(const StepInput& in, const SurfaceEstimate& surface) noexcept;
  void update_approach(const SurfaceEstimate& surface) noexcept;
  void update_rise(const StepInput& in) noexcept;
  void update_felt_normal(const Vector6& F_ext) noexcept;

  bool measured_;
  double dt_, normal_force_;
  FrictionSettings friction_;
  ApproachSettings approach_;
  ContactStates states_;
  NormalTracker tracker_;
  FeltNormal felt_;
  bool carried_ = false;                           // on the surface of a carrier
  Eigen::Vector3d v_K_ = Eigen::Vector3d::Zero();  // of the last step then
  double approach_distance_ = 0.0;                 // to the surface, desired in approach [m]
  Contact now_;
};

}  // namespace impedraw

// Finds the arm's posture for a pen placement by inverse kinematics, seeded with the previous
// posture, and checks it.
//
// Seed   q + (1 − exp(−moved/kRelax)) N (q_0 − q + τ_limit / K_q),  N = I − J⁺ J
// This imitates the null-space torque of the controller on the redundant joint (null_space.h). N is
// the kinematic projector; for one redundant joint it projects onto the same line. From one posture
// to the next the pen turns about its axis only away from the ends of joints' ranges (heading.h):
// elsewhere the controller damps that turn.
#pragma once

#include <optional>
#include <string>

#include "impedraw/arm/arm_model.h"
#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/control/joint_range.h"
#include "impedraw/control/operational_space.h"
#include "impedraw/planning/preflight/clearance.h"
#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

inline constexpr double kRelax = 0.05;  // tip path over which the redundant joints settle [m]

struct Posture {
  JointVector q;  // if the point is not reached: the nearest posture found
  bool reached = false;
  JointVector drift;               // N (q_0 − q + τ_limit / K_q) [rad]
  std::optional<Problem> problem;  // out_of_reach to pen_collision, the first that applies
  double amount = 0;               // severity of the problem; larger is worse
  std::string text;
  PreflightMargins margins;  // of this posture; slope is not set
};

// As the arm stands, with nothing looked at.
inline Posture standing_at(const JointVector& q) {
  Posture posture;
  posture.q = q;
  posture.reached = true;
  posture.drift = JointVector::Zero(q.size());
  return posture;
}

// Joint torques that hold the arm still and press the pen on with `normal_force` [N] along `axis`
// (into the surface, W), while friction across it takes the direction that is worst for each joint
// [Nm]: |g_j + J_jᵀ axis F| + μ F |J_jᵀ across axis|. ≥ 0.
JointVector holding_torque(const ArmTerms& terms, const Eigen::Vector3d& axis, double normal_force,
                           double friction);

// Checks postures for pen placements. n is the pen's axis, outward. World frame W.
class PostureCheck {
 public:
  // The canvas must outlive this object. Throws InputError if start_q or rest_q does not have
  // one entry per joint.
  PostureCheck(const ArmModel& arm, const Canvas* obstacle, const JointVector& start_q,
               const PreflightSettings& settings);

  // The posture of an arm at q: as it stands, if its pen is there, else as enter() finds it.
  Posture begin(const PenPlacement& pen, const JointVector& q);

  // Finds a settled posture at the point, seeded with `last`, then the rest or the start posture.
  // Returns the first posture without a problem, else the first that reaches, else the nearest.
  Posture enter(const PenPlacement& pen, const JointVector& last);

  // Continues from the last posture after the tip has moved by `moved` [m], in that time [s].
  Posture follow(const PenPlacement& pen, const Posture& last, double moved,
                 std::optional<double> time = {});

  // Moves the canvas there; at first its frame K is W.
  void move_canvas(const Pose& X_WK) { clearance_.move_canvas(X_WK); }

  // Enabled checks. Disable torque in the air, and pen with the tip pressed below the surface.
  struct Asked {
    bool torque = true, pen = true;
  };
  Asked asked;

  // The joint that differs most, and its difference [rad].
  struct Change {
    int joint = 0;
    double by = 0;
  };
  static Change change(const Posture& a, const Posture& b);
  // The greatest change by which an arm follows a pen that moves by `moved` [m] and turns by
  // `turned` [rad]: a turn of the pen can move a wrist joint several times as far.
  double most_change(double moved, double turned) const {
    return settings_.max_joint_step + 3.0 * turned +
           moved / settings_.step * settings_.max_joint_step / 2.0;
  }

 private:
  Posture solve(const PenPlacement& pen, const JointVector& seed, int max_steps,
                bool free_spin = true);
  void examine(const PenPlacement& pen, Posture* posture);
  void say_unreached(const PenPlacement& pen, const IkResult& found, Posture* posture);
  JointVector drift(const JointVector& q) const;
  JointVector turned(double time);
  double effective_mass() const;

  ArmModel arm_;
  PreflightSettings settings_;
  JointVector start_, rest_;
  Clearance clearance_;
  ArmTerms terms_;
  ImpedanceSettings law_;  // its defaults
  JointRange range_;
  OperationalSpace space_;
};

}  // namespace impedraw

// One posture of the arm with its pen on a point: found by inverse kinematics from the last, and
// checked.
//
// Seed   q + (1 − exp(−moved/kRelax)) N (q_0 − q),  N = I − J⁺ J
// as the controller's null space draws the spare joint (impedance.h); N is the kinematic projector,
// for one spare joint the same line.
#pragma once

#include <optional>
#include <string>

#include "impedraw/arm/arm_model.h"
#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/planning/preflight/clearance.h"
#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

struct Posture {
  JointVector q;  // best, where the point is not reached
  bool reached = false;
  JointVector drift;               // N (q_0 − q) [rad]
  std::optional<Problem> problem;  // out_of_reach to pen_collision, the first that applies
  double amount = 0;               // of it; larger is worse
  std::string text;
  PreflightMargins margins;  // of this posture; no slope
};

// What of the surface the tip is on: n is the pen's axis, outward. World frame W.
class PostureCheck {
 public:
  // Canvas and arm must outlive it. InputError: start_q or rest_q has not as many entries as the
  // arm has joints.
  PostureCheck(ArmModel& arm, const Canvas* obstacle, const JointVector& start_q,
               const PreflightSettings& settings);

  // The arm comes to the point anew, from `last` or else from the rest or the start posture, and
  // comes to rest there: the first posture without a problem, or the first that reaches, or the one
  // that gets nearest.
  Posture enter(const PenPlacement& pen, const JointVector& last);

  // On from the last posture, the tip having moved by so much [m].
  Posture follow(const PenPlacement& pen, const Posture& last, double moved);

  // What is asked. In the air: no torque. With the tip pressed below the surface: no pen.
  struct Asked {
    bool torque = true, pen = true;
  };
  Asked asked;

  // Joint that differs most, and by how much [rad].
  struct Change {
    int joint = 0;
    double by = 0;
  };
  static Change change(const Posture& a, const Posture& b);

 private:
  Posture solve(const PenPlacement& pen, const JointVector& seed, int max_steps);
  void examine(const PenPlacement& pen, Posture* posture);
  void say_unreached(const PenPlacement& pen, const IkResult& found, Posture* posture);
  JointVector drift(const JointVector& q) const;
  double effective_mass() const;

  ArmModel& arm_;
  PreflightSettings settings_;
  JointVector start_, rest_;
  Clearance clearance_;
  ArmTerms terms_;
};

}  // namespace impedraw

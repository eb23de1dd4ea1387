// The places in W where the arm can have its pen, and its joint speeds when the pen moves there;
// hence the windows of time in which a stroke may be drawn on a canvas that moves.
//
// The arm stands the same wherever the canvas goes: places are asked for again and again, by each
// stroke and at each decision. One posture is kept for places within kCell and axes within kTurn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/planning/preflight/posture_check.h"

namespace impedraw {

// From `from` on, and to be finished by `until` [s].
struct ReachWindow {
  double from = 0.0, until = 0.0;
};

// X_WK, one every `step` from `begin` on [s].
struct CanvasPoses {
  double begin = 0.0, step = 0.1;
  std::vector<Pose> X_WK;
};

class ReachMap {
 public:
  static constexpr double kCell = 0.01, kTurn = 0.1;  // [m], [rad]

  // settings: reach, joint range, singular postures, torque and the table are checked. q: a posture
  // to begin with.
  ReachMap(const ArmModel& arm, const JointVector& q, const PreflightSettings& settings);

  // When a stroke may be approached, to be finished at its last point: while the pen comes down to
  // it, goes along it and up again, all of its places are in reach, one for each of the canvas's
  // poses, and no joint is so fast that the plan's clock would yield (joint_speed_shares.h).
  // along: for so long the pen stays with the canvas at the end of its lift [s]. is_down: it need
  // not come down, as another stroke ends there; begun at its first point then.
  std::vector<ReachWindow> windows(const TipPath& path, std::size_t stroke,
                                   const CanvasPoses& canvas, double along = 0.0,
                                   bool is_down = false);

 private:
  bool reaches(const PenPlacement& from, const PenPlacement& to, double time);
  // J̄ there (least_energy_step.h) over the joints' greatest speeds; empty: out of reach.
  const Eigen::MatrixXd& cell(const PenPlacement& pen);

  ArmModel arm_;
  JointVector q_;
  PostureCheck check_;
  ArmTerms terms_;
  Posture last_;  // that was in order
  std::unordered_map<std::uint64_t, Eigen::MatrixXd> cells_;
};

}  // namespace impedraw

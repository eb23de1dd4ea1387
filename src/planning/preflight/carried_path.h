// Checks a planned path on a canvas that moves, before it is followed.
//
// The path is in the canvas's frame K; `wanted` says where it has the pen in W. Postures follow
// each other every 50 ms as in the pre-flight (posture_check.h), from the one in which the arm is:
//   reach, joint range, singular postures, torque with the pen down, the arm against canvas and
//   table where the canvas then is, and
//   joint speeds |dq_j| / dt of the motion of least kinetic energy (least_energy_step.h), canvas's
//   motion included, up to what the law may ask for; a plan's clock that yields does not slow the
//   canvas.
//
// And for one stroke, when it may be drawn: windows of time (ReachMap).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/planning/preflight/posture_check.h"
#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

// X_WK as predicted for a time [s].
using CanvasCourse = std::function<Pose(double time)>;

struct CarriedPath {
  const TipPath* path = nullptr;  // in K
  double begin = 0.0;             // time at which it begins [s]
  CanvasCourse canvas;
  // The path's reference at a time, in W; empty: X_WK(time) takes it there.
  std::function<TipReference(const TipReference& in_K, double time)> in_world;
};

// The fault that keeps a stroke from being drawn, on the way to it, along it or on the way off.
struct CarriedFault {
  std::size_t stroke = 0;  // in the path's order
  double time = 0.0;       // when it begins [s]
  double short_by = 0.0;   // how far the pen stays off at worst, until the stroke's end [m]
  std::string what, how;   // "leaves the arm's reach", "0.14 m short"
};

// The first stroke that cannot be drawn; nothing: all that begin before `until` can [s of the
// path]. `from`: of the path [s]; q: the arm's posture there. obstacle: in K; null: none.
std::optional<CarriedFault> check_carried(const CarriedPath& carried, ArmModel arm,
                                          const Canvas* obstacle, const JointVector& q,
                                          const PreflightSettings& settings, double from = 0.0,
                                          double until = std::numeric_limits<double>::infinity());

// From `from` on, and to be finished by `until` [s].
struct ReachWindow {
  double from = 0.0, until = 0.0;
};

// X_WK, one every `step` from `begin` on [s].
struct CanvasPoses {
  double begin = 0.0, step = 0.1;
  std::vector<Pose> X_WK;
};

// Where in W the arm can have its pen, and how fast its joints are when the pen moves there.
//
// The arm stands the same wherever the canvas goes: places are asked for again and again, by each
// stroke and at each decision. One posture is kept for places within kCell and axes within kTurn.
class ReachMap {
 public:
  static constexpr double kCell = 0.01, kTurn = 0.1;  // [m], [rad]

  // settings: reach, joint range, singular postures, torque and the table are checked. q: a posture
  // to begin with.
  ReachMap(const ArmModel& arm, const JointVector& q, const PreflightSettings& settings);

  // When a stroke may be approached, to be finished at its last point: while the pen comes down to
  // it, goes along it and up again, all of its places are in reach, one for each of the canvas's
  // poses, and no joint is so fast that the plan's clock would yield (joint_speed_shares.h).
  std::vector<ReachWindow> windows(const TipPath& path, std::size_t stroke,
                                   const CanvasPoses& canvas);

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

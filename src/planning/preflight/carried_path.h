// Checks a planned path on a canvas that moves, before it is followed.
//
// The path is in the canvas's frame K; `wanted` says where it has the pen in W. Postures follow
// each other every 50 ms as in the pre-flight (posture_check.h), from the one in which the arm is:
//   reach, joint range, singular postures, torque with the pen down, the arm against canvas and
//   table where the canvas then is, and
//   joint speeds |dq_j| / dt of the motion of least kinetic energy (least_energy_step.h), canvas's
//   motion included, up to what the law may ask for; a plan's clock that yields does not slow the
//   canvas.
// The canvas still takes the pen along as it leaves it after the last stroke.
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/planning/path/tip_path.h"
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
  double along = 0.0;  // after the last lift the pen goes with the canvas for so long [s]
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

}  // namespace impedraw

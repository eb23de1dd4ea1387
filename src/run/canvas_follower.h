// The plan follows the canvas: references of frame K, the canvas's, as they are in W now.
//
// Before join() references are given in W: the arm watches. From join() on they are given in K. The
// reference goes over within kJoin or longer, p = p_W + σ (p_K − p_W) with a minimum-jerk σ(t), so
// that the pen picks up the canvas's motion without a jolt.
#pragma once

#include <functional>
#include <limits>
#include <utility>

#include "impedraw/common/pose.h"
#include "impedraw/control/canvas_estimate.h"
#include "impedraw/control/tip_reference.h"

namespace impedraw {

// The estimate for a time [s] of the driver's clock. Called once per control step; must not
// allocate.
using CanvasSource = std::function<CanvasEstimate(double time)>;

class CanvasFollower {
 public:
  static constexpr double kJoin = 1.5;  // [s]

  // `source` empty: the canvas stands, K is W.
  explicit CanvasFollower(CanvasSource source) : source_(std::move(source)) {}

  bool follows() const noexcept { return static_cast<bool>(source_); }
  // References are in K, and the pen moves with the canvas.
  bool joined() const noexcept { return joined_at_ < std::numeric_limits<double>::infinity(); }

  // Once per control step.
  void update(double time) noexcept {
    if (!follows()) return;
    estimate_ = source_(time);
    time_ = time;
  }
  // From now on references are given in K. `in_W`: the last one in W, at rest. Within `duration`
  // the pen goes over to them [s].
  void join(const TipReference& in_W, double duration = kJoin) noexcept {
    joined_at_ = time_;
    duration_ = duration;
    from_ = in_W;
  }
  // References are in W again.
  void leave() noexcept { joined_at_ = std::numeric_limits<double>::infinity(); }

  const CanvasEstimate& estimate() const noexcept { return estimate_; }
  // X_WK as estimated; the identity where the canvas stands.
  const Pose& pose() const noexcept { return estimate_.motion.X_WK; }
  // Null unless the pen moves with the canvas.
  const FrameMotion* carrier() const noexcept { return joined() ? &estimate_.motion : nullptr; }
  bool lost() const noexcept {
    return joined() &&
           (estimate_.status == CanvasStatus::stale || estimate_.status == CanvasStatus::lost);
  }

  TipReference in_world(const TipReference& reference) const noexcept;

 private:
  CanvasSource source_;
  CanvasEstimate estimate_;
  double time_ = 0.0;
  double joined_at_ = std::numeric_limits<double>::infinity(), duration_ = kJoin;
  TipReference from_;
};

}  // namespace impedraw

// The plan follows the canvas: references of frame K, the canvas's, as they are in W now.
//
// Before join() references are given in W: the arm watches. From join() on they are given in K, and
// from leave() on in W again. The pen goes over within a given time, p = p_a + σ (p_b − p_a) with a
// minimum-jerk σ(t), so that it picks up the canvas's motion, or sheds it, without a jolt: a canvas
// that rises does not run into a pen that has just been lifted.
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
    left_at_ = -std::numeric_limits<double>::infinity();
    duration_ = duration;
    from_ = in_W;
  }
  // References are in W again. Within `duration` the pen goes over to them; meanwhile they are also
  // carried along, from where K is now. A canvas that is lost carries nothing.
  void leave(double duration = 0.0) noexcept {
    left_at_ = joined() && !lost() ? time_ : -std::numeric_limits<double>::infinity();
    duration_ = duration;
    X_WK_left_ = pose();
    joined_at_ = std::numeric_limits<double>::infinity();
  }

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
  double left_at_ = -std::numeric_limits<double>::infinity();
  TipReference from_;
  Pose X_WK_left_;
};

}  // namespace impedraw

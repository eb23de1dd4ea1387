// The plan follows the canvas: references of frame K, the canvas's, as they are in W now.
//
// Before join() references are given in W: the arm watches. From join() on they are given in K, and
// from leave() on in W again. The pen goes over within a given time, p = p_a + σ (p_b − p_a) with a
// minimum-jerk σ(t), so that it picks up the canvas's motion, or sheds it, without a jolt: a canvas
// that rises does not run into a pen that has just been lifted.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <utility>

#include "impedraw/common/minimum_jerk.h"
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
  static constexpr double kShed = 0.3;  // [s]

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
  // References are in W again. Within `duration` the pen goes over to them along up_W, and across
  // it within kShed at most; meanwhile they are also carried along, from where K is now. A canvas
  // that is lost carries nothing.
  void leave(double duration = 0.0,
             const Eigen::Vector3d& up_W = Eigen::Vector3d::Zero()) noexcept {
    up_ = up_W;
    left_at_ = joined() && !lost() ? time_ : -std::numeric_limits<double>::infinity();
    duration_ = duration;
    X_WK_left_ = pose();
    joined_at_ = std::numeric_limits<double>::infinity();
  }

  // It was left without haste, and still takes the pen along.
  bool leaves() const noexcept {
    return !joined() && duration_ > kShed && time_ - left_at_ < kShed;
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

  TipReference in_world(const TipReference& reference) const noexcept {
    const double since = time_ - (joined() ? joined_at_ : left_at_);
    const bool over = since >= duration_;
    if (joined()) {
      const TipReference out = carried(reference, estimate_.motion);
      return over ? out : between(from_, out, std::max(0.0, since / duration_), duration_);
    }
    if (over) return reference;
    const Pose X_KW = X_WK_left_.inverse();
    TipReference in_K = reference;
    in_K.p_WD = X_KW * reference.p_WD;
    for (Eigen::Vector3d TipReference::*member :
         {&TipReference::v_WD, &TipReference::a_WD, &TipReference::n_WD, &TipReference::w_WD,
          &TipReference::alpha_WD, &TipReference::x_WD})
      in_K.*member = X_KW.R * in_K.*member;
    const TipReference along = carried(in_K, estimate_.motion);
    const auto within = [&](double duration) {
      return since >= duration
                 ? reference
                 : between(along, reference, std::max(0.0, since / duration), duration);
    };
    const TipReference slow = within(duration_);
    TipReference out = within(std::min(duration_, kShed));
    for (Eigen::Vector3d TipReference::*member :
         {&TipReference::p_WD, &TipReference::v_WD, &TipReference::a_WD})
      out.*member += up_ * up_.dot(slow.*member - out.*member);
    return out;
  }

 private:
  // From a to b, at u of 0 to 1 of the time.
  static TipReference between(const TipReference& a, const TipReference& b, double u,
                              double duration) {
    const auto [share, rate, change] = MinimumJerk::at(u, duration);
    const Eigen::Vector3d way = b.p_WD - a.p_WD, faster = b.v_WD - a.v_WD;
    TipReference out = b;
    out.p_WD = a.p_WD + share * way;
    out.v_WD = a.v_WD + share * faster + rate * way;
    out.a_WD = a.a_WD + share * (b.a_WD - a.a_WD) + 2.0 * rate * faster + change * way;
    out.n_WD = ((1.0 - share) * a.n_WD + share * b.n_WD).normalized();
    out.w_WD = (1.0 - share) * a.w_WD + share * b.w_WD;
    out.alpha_WD = (1.0 - share) * a.alpha_WD + share * b.alpha_WD;
    return out;
  }

  CanvasSource source_;
  CanvasEstimate estimate_;
  double time_ = 0.0;
  double joined_at_ = std::numeric_limits<double>::infinity(), duration_ = kJoin;
  double left_at_ = -std::numeric_limits<double>::infinity();
  TipReference from_;
  Pose X_WK_left_;
  Eigen::Vector3d up_ = Eigen::Vector3d::Zero();
};

}  // namespace impedraw

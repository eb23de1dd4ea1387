// Notices that the pen stands before a wall that the cameras did not see as one: the crease between
// two bodies, for instance. The plan moves on, the tip does not, and the surface pushes it back.
//
// A hand that pushes the pen aside does not look like that for long: the tip gives way by F/k, and
// follows the plan again.
#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace impedraw {

// Notices that the surface pushes the tip aside, far off the estimated normal, for longer than
// roughness does: the tip touches the foot of a wall with its side. While it comes down, too.
class SideWatch {
 public:
  static constexpr double kForce = 4.0;     // across the estimated normal, at least [N]
  static constexpr double kSteep = 2.1;     // of the force along it: 65°
  static constexpr double kConfirm = 0.05;  // [s]

  void reset() noexcept { aside_ = 0.0; }

  // One cycle with the tip on the surface, or on its way down. n: estimated normal; F: force of the
  // canvas on the tip [N]. True in the cycle in which the wall is certain.
  bool update(const Eigen::Vector3d& n, const Eigen::Vector3d& F, double dt) noexcept {
    const double along = n.dot(F), across = (F - along * n).norm();
    const bool aside = across > kForce && across > kSteep * along;
    aside_ = aside ? aside_ + dt : std::max(0.0, aside_ - dt);
    if (aside_ < kConfirm) return false;
    aside_ = 0.0;
    return true;
  }

 private:
  double aside_ = 0.0;  // [s]
};

// Notices that the tip sinks where the cameras saw a surface: into a gap that is narrower than they
// resolve. Held just beneath the surface it would go on, and catch under the gap's far side.
class SinkWatch {
 public:
  static constexpr double kSunk = 1.5e-3;     // below the last touch, or the estimate [m]
  static constexpr double kDeepest = 3.0e-3;  // below the estimated surface, before any touch [m]
  // A surface that holds the tip falls by less, below the estimated one, per way along it. Along
  // the side of a gap the tip is touched, too, and goes down. Blows shorter than kHeld tell
  // nothing [s].
  static constexpr double kSteepest = 2.0, kHeld = 0.03;

  void reset() noexcept { *this = {}; }

  // One cycle with the tip on the surface, or on its way down. distance: to the estimated surface
  // [m]; way: of the tip along it in this cycle [m]; touches: the surface holds the tip. True while
  // the tip is too deep.
  bool update(double distance, double way, bool touches, double dt) noexcept {
    held_ = touches ? held_ + dt : 0.0;
    way_ += way;
    if (touches && std::isfinite(distance)) {
      const double least = held_ < kHeld ? distance : at_touch_ - kSteepest * way_;
      at_touch_ = std::min(0.0, std::max(distance, least));
      way_ = 0.0;
    }
    return distance < at_touch_ - kSunk;
  }

 private:
  double at_touch_ = kSunk - kDeepest;  // [m]
  double way_ = 0.0;                    // since the last touch [m]
  double held_ = 0.0;                   // touched without a break [s]
};

class WallWatch {
 public:
  // Against the desired motion: no less than this [N], and than this share of the normal force,
  // which friction stays below.
  static constexpr double kForce = 4.0, kForceShare = 0.8;
  static constexpr double kProgress = 0.3;     // of the desired speed
  static constexpr double kLeastSpeed = 2e-3;  // desired [m/s]
  static constexpr double kBehind = 1.0e-3;    // of the desired point [m]
  static constexpr double kConfirm = 0.06;     // [s]

  void reset() noexcept { stuck_ = 0.0; }

  // One cycle while a stroke is drawn. n: estimated normal; v_D: desired velocity of the tip and v
  // its own [m/s]; behind: from the tip to the desired point [m]; F: of the canvas on the tip [N].
  // True in the cycle in which the wall is certain.
  bool update(const Eigen::Vector3d& n, const Eigen::Vector3d& v_D, const Eigen::Vector3d& v,
              const Eigen::Vector3d& behind, const Eigen::Vector3d& F, double dt) noexcept {
    const Eigen::Vector3d along = v_D - n * n.dot(v_D);
    const double speed = along.norm();
    if (speed < kLeastSpeed) return false;  // says nothing
    const Eigen::Vector3d way = along / speed;
    const double least = std::max(kForce, kForceShare * n.dot(F));
    const bool stuck =
        way.dot(v) < kProgress * speed && -way.dot(F) > least && way.dot(behind) > kBehind;
    stuck_ = stuck ? stuck_ + dt : std::max(0.0, stuck_ - dt);
    if (stuck_ < kConfirm) return false;
    stuck_ = 0.0;
    return true;
  }

 private:
  double stuck_ = 0.0;  // [s]
};

}  // namespace impedraw

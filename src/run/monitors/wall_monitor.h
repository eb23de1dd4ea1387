// Notices that the pen stands before a wall that the cameras did not see as one: the crease between
// two bodies, for instance. The plan moves on, the tip does not, and the surface pushes it back.
//
// A hand that pushes the pen aside does not look like that for long: the tip gives way by F/k, and
// follows the plan again.
#pragma once

#include <algorithm>

#include <Eigen/Core>

namespace impedraw {

class WallMonitor {
 public:
  // Against the desired motion: no less than this [N], and than this share of the normal force,
  // which friction stays below.
  static constexpr double kForce = 4.0, kForceShare = 0.8;
  static constexpr double kProgress = 0.3;     // least share of the desired speed
  static constexpr double kLeastSpeed = 2e-3;  // desired [m/s]
  static constexpr double kBehind = 1.0e-3;    // lag behind the desired point [m]
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

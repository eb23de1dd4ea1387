// Notices that the surface pushes the tip aside, far off the estimated normal, for longer than
// roughness does: the tip touches the foot of a wall with its side. While it comes down, too.
//
// A canvas only pushes. Where it pulls, the ball of the tip is caught beneath something that the
// cameras do not resolve, a wire for instance.
#pragma once

#include <algorithm>

#include <Eigen/Core>

namespace impedraw {

class SideMonitor {
 public:
  static constexpr double kForce = 4.0;     // across the estimated normal, at least [N]
  static constexpr double kSteep = 2.1;     // times the force along it: 65°
  static constexpr double kConfirm = 0.05;  // [s]
  // steep: the same, where the law expects more across: a cutter of a slim cone.
  explicit SideMonitor(double steep = kSteep) noexcept : steep_(std::max(kSteep, steep)) {}

  // Against the estimated normal [N]; a caught ball meets ground and wire in turns [s].
  static constexpr double kPull = 2.0, kConfirmPull = 2e-3, kForgetPull = 16e-3;

  void reset() noexcept { aside_ = pull_ = 0.0; }

  // One cycle with the tip on the surface, or on its way down. n: estimated normal; F: force of the
  // canvas on the tip [N]. True in the cycle in which the wall is certain.
  bool update(const Eigen::Vector3d& n, const Eigen::Vector3d& F, double dt) noexcept {
    const double along = n.dot(F), across = (F - along * n).norm();
    const bool aside = across > kForce && across > steep_ * along;
    aside_ = aside ? aside_ + dt : std::max(0.0, aside_ - dt);
    pull_ = along < -kPull ? pull_ + dt : pull_ * (1.0 - dt / (kForgetPull + dt));
    caught_ = pull_ >= kConfirmPull;
    if (aside_ < kConfirm && !caught_) return false;
    reset();
    return true;
  }
  // The last update's certainty is a ball that is caught.
  bool caught() const noexcept { return caught_; }

 private:
  double steep_;
  double aside_ = 0.0, pull_ = 0.0;  // [s]
  bool caught_ = false;
};

}  // namespace impedraw

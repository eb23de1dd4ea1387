// Motion of the true canvas in the world. Frame K is fixed to the canvas and coincides with W as
// long as nothing has moved: a mesh is placed in W, and its coordinates are those in K from then
// on.
//
//   p_W = c + d(t) + R(t) (p_K − c)         R(t) = Rot(turn axis, θ(t)) · Rot(sway axis, ψ(t))
//
//   d = velocity · u(t) + Σ sway + jolts    u: time since `start`, with a smooth start and stop
//   θ = turn_speed · u(t)
//
// Or X_WK = X(u(t)) of a recorded motion, which slows down to end with the record.
//
// Nothing in perception, planning or control may read it: they see frames of cameras and forces.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "impedraw/common/pose.h"
#include "impedraw/simulation/recorded_motion.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

class CanvasMotion {
 public:
  // Pose and motion of the canvas.
  struct State {
    Pose X_WK;
    Eigen::Vector3d v = Eigen::Vector3d::Zero();  // of the point that is at `centre` in K [m/s]
    Eigen::Vector3d w = Eigen::Vector3d::Zero();  // angular velocity, W [rad/s]
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // of that point, W [m]

    // of the canvas's point that is at p_W now [m/s]
    Eigen::Vector3d velocity_at(const Eigen::Vector3d& p_W) const {
      return v + w.cross(p_W - centre);
    }
  };

  CanvasMotion() = default;  // stands still
  // Reads the file if there is one. Throws InputError, which names the field.
  explicit CanvasMotion(const CanvasMotionSettings& settings);

  bool moves() const { return moves_; }

  // Any t; before `start` at rest. Allocates nothing.
  State at(double t) const noexcept;

 private:
  struct Wave {
    Eigen::Vector3d amplitude;
    double rate, phase;  // [rad/s], [rad]
  };

  State recorded_at(double t) const noexcept;

  CanvasMotionSettings settings_;
  bool moves_ = false;
  std::vector<Wave> jolts_;
  std::shared_ptr<const RecordedMotion> recorded_;
};

}  // namespace impedraw

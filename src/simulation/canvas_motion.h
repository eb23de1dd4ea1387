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

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/common/pose.h"
#include "impedraw/common/range.h"
#include "impedraw/simulation/recorded_motion.h"

namespace impedraw {

struct CanvasMotionSettings {
  // c: what the canvas turns and rolls about, W [m]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();

  // Conveyor and turntable. From `start` to `stop` [s]; each takes `ramp` [s] to reach or to leave
  // full speed, the acceleration is bounded and continuous.
  double start = 0.0, ramp = 0.5;
  std::optional<double> stop;                          // absent: never
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // W [m/s]
  Eigen::Vector3d turn_axis = Eigen::Vector3d::UnitZ();
  double turn_speed = 0.0;  // about turn_axis through the centre [rad/s]

  // Heave and sway: amplitude · sin(2π frequency (t − start)), its amplitude grows over `ramp`.
  Eigen::Vector3d sway = Eigen::Vector3d::Zero();  // amplitude, W [m]
  double sway_frequency = 0.5;                     // [Hz]
  Eigen::Vector3d roll_axis = Eigen::Vector3d::UnitX();
  double roll = 0.0;            // amplitude about roll_axis through the centre [rad]
  double roll_frequency = 0.3;  // [Hz]

  // A hand that jolts it: noise along each axis of W, its spectrum flat up to `jolt_bandwidth`.
  double jolts = 0.0;           // RMS [m]
  double jolt_bandwidth = 1.0;  // [Hz]
  std::uint64_t seed = 1;

  // A recorded motion (recorded_motion.h), in place of all of these. Empty: none.
  std::filesystem::path file;

  struct Limits {
    static constexpr Limit centre = {"centre", "m", {-10.0, 10.0}};
    static constexpr Limit start = {"start", "s", {-1e4, 1e4}};
    static constexpr Limit stop = {"stop", "s", {-1e4, 1e6}};
    static constexpr Limit turn_axis = {"turn_axis", "", {-1.0, 1.0}};
    static constexpr Limit roll_axis = {"roll_axis", "", {-1.0, 1.0}};
    static constexpr Limit ramp = {"ramp", "s", {0.01, 60.0}};
    static constexpr Limit speed = {"velocity", "m/s", {-2.0, 2.0}};
    static constexpr Limit turn_speed = {"turn_speed", "rad/s", {-10.0, 10.0}};
    static constexpr Limit sway = {"sway", "m", {-1.0, 1.0}};
    static constexpr Limit sway_frequency = {"sway_frequency", "Hz", {0.0, 20.0}};
    static constexpr Limit roll = {"roll", "rad", {-1.0, 1.0}};
    static constexpr Limit roll_frequency = {"roll_frequency", "Hz", {0.0, 20.0}};
    static constexpr Limit jolts = {"jolts", "m", {0.0, 0.1}};
    static constexpr Limit jolt_bandwidth = {"jolt_bandwidth", "Hz", {0.01, 20.0}};
  };
};

class CanvasMotion {
 public:
  // Where the canvas is, and how it moves.
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

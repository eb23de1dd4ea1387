// Fences: a box, a force and a speed of the tip that end a run.
//
// Speed and force must be beyond for kConfirm: a single outlier of a sensor is none. What is not
// finite is not judged here: the control law says bad_input.
#pragma once

#include <string>

#include <Eigen/Core>

#include "impedraw/experiment/scenario.h"

namespace impedraw {

class Fences {
 public:
  static constexpr double kConfirm = 3e-3;  // [s]

  // `measured`: the force on the tip is. Throws InputError if the box is empty, or a force is given
  // and not measured.
  Fences(const FenceSettings& settings, bool measured);

  // p_WE [m], v_WE [m/s], f: force on the tip, W [N]. True in the cycle in which a fence is first
  // crossed.
  bool update(const Eigen::Vector3d& p_WE, const Eigen::Vector3d& v_WE, const Eigen::Vector3d& f,
              double dt) noexcept;

  // What was crossed, with the value and the fence. Empty: nothing.
  std::string crossed() const;

 private:
  enum class Kind { none, box, force, speed };

  FenceSettings settings_;
  Kind kind_ = Kind::none;
  int axis_ = 0;
  double value_ = 0.0;
  double force_above_ = 0.0, speed_above_ = 0.0;  // [s]
};

}  // namespace impedraw

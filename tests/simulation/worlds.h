// The worlds of this folder's tests, and states of the iiwa.
#pragma once

#include <random>

#include "impedraw/canvas/built_in.h"
#include "impedraw/simulation/world.h"

namespace impedraw::testing_worlds {

inline constexpr const char* kArm = "models/iiwa14_pen.urdf";
inline constexpr const char* kSlider = "tests/data/slider.urdf";

inline WorldSettings with(const ModelErrors& errors, double dt = 1e-3) {
  WorldSettings settings;
  settings.errors = errors;
  settings.dt = dt;
  return settings;
}

inline JointVector working_posture() {
  JointVector q(7);
  q << 0.1, 0.6, -0.1, -1.4, 0.2, 1.1, 0.3;
  return q;
}

inline JointVector random_vector(std::mt19937& rng, int n, double most) {
  std::uniform_real_distribution<double> any(-most, most);
  JointVector v(n);
  for (double& value : v) value = any(rng);
  return v;
}

// A level square of 1 m, at a height at which a tip at the given point penetrates it by
// `depth`.
inline Canvas plane_under(const Eigen::Vector3d& p_W, double depth) {
  PlaneSettings settings;
  settings.centre = p_W + depth * Eigen::Vector3d::UnitZ();
  settings.width = settings.height = 1.0;
  return Canvas(make_plane(settings));
}

}  // namespace impedraw::testing_worlds

// Settings of the surface learned from touch: touch_surface.h.
#pragma once

#include <Eigen/Core>

namespace impedraw {

struct TouchSettings {
  double slope = 0.6;              // standard deviation of g before the first touch
  double curvature = 10.0;         // κ: of H [1/m]
  double curvature_length = 0.03;  // ℓ: over which H changes [m]
  double position_noise = 20e-6;   // of a touched height [m]
  double force_noise = 0.05;       // of the slope that a force tells, over `spacing`
  double spacing = 50e-6;          // of the touched points along the path [m]
  double slip_speed = 5e-3;        // slower, the direction of friction is not known [m/s]
  double turn_rate = 0.7;          // greatest of the reported normal [rad/s]
  double search = 5e-3;            // beneath a surface that has been touched [m]
  double settle_time = 0.1;        // from a touch to the use of the standing force [s]
};

// The controller's belief about pen and step.
struct TouchModel {
  double dt = 1e-3;                                           // [s]
  Eigen::Vector3d drawing_axis_W = Eigen::Vector3d::UnitZ();  // z, unit
  double tip_radius = 1e-3;                                   // [m]
  double tip_stiffness = 20e3;                                // along the normal [N/m]; 0: rigid
  double friction = 0.3;                                      // μ, while the pen stands
  double touch_force = 0.3;                                   // [N]
};

}  // namespace impedraw

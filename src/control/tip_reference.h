// Planned motion of the pen tip at one instant.
#pragma once

#include <Eigen/Core>

namespace impedraw {

// World frame W, SI. D is the desired tip frame: origin p_WD, z_D = −n_WD (the pen points into the
// surface). The rotation about z_D is free, or led: x_WD then is the tool's x axis.
struct TipReference {
  Eigen::Vector3d p_WD = Eigen::Vector3d::Zero();  // [m]
  Eigen::Vector3d v_WD = Eigen::Vector3d::Zero();  // [m/s]
  Eigen::Vector3d a_WD = Eigen::Vector3d::Zero();  // [m/s²]
  // outward unit normal of the planned surface
  Eigen::Vector3d n_WD = Eigen::Vector3d::UnitZ();
  // angular velocity of n_WD, without a component about n_WD [rad/s]
  Eigen::Vector3d w_WD = Eigen::Vector3d::Zero();
  Eigen::Vector3d alpha_WD = Eigen::Vector3d::Zero();  // its derivative [rad/s²]
  // contact is desired: from the start of the approach to the start of the lift
  // Across n_WD, unit: the heading is led (heading.h); zero: it is free.
  Eigen::Vector3d x_WD = Eigen::Vector3d::Zero();
  double yaw_rate = 0.0;          // of x_WD about n_WD, beyond w_WD [rad/s]
  double yaw_acceleration = 0.0;  // its derivative [rad/s²]
  bool led() const noexcept { return x_WD.squaredNorm() > 0.5; }
  bool pen_down = false;
  double force = 0.0;       // F_n along the normal [N]; 0: ImpedanceSettings::normal_force
  double force_rate = 0.0;  // its derivative [N/s]
  // below the touched surface, which a cutter holds [m]; 0: by the force alone
  double depth = 0.0;
};

}  // namespace impedraw

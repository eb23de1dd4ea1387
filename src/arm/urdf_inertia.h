// Mass and inertia of a URDF's link, as its <inertial> tells them: in kg and kg m², about the
// centre of mass, in the axes of its <origin>.
#pragma once

#include <Eigen/Core>

#include "impedraw/arm/urdf_tree.h"

namespace impedraw {

// Zero where there is no <inertial>, or it lacks them.
Eigen::Matrix3d inertia_of(const UrdfElement* inertial);
double mass_of(const UrdfElement* inertial);

// Writes both into the link's <inertial>, which it makes where there is none.
void set_inertial(UrdfElement* link, double mass, const Eigen::Matrix3d& I);

}  // namespace impedraw

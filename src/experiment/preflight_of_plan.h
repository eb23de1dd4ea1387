// The pre-flight's settings, completed from the rest of the scenario.
#pragma once

#include <functional>

#include "impedraw/experiment/belief.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

// `seen`: cameras know the surface, so that the pen follows its normal. rest_q: the null space's.
PreflightSettings preflight_settings(const Scenario& scenario, const Pose& X_WP, bool seen,
                                     const JointVector& rest_q);

// By how much the surface, as perceived, may be off [m]; for PreflightSettings::height_error.
// Refers to the belief.
std::function<double(const Eigen::Vector3d&)> height_error(const Belief& belief);

}  // namespace impedraw

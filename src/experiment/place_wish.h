// The wish for a place on a surface, for place_search.h: it lies near, the arm reaches it at ease,
// and it is not rough.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "impedraw/experiment/belief.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/planning/preflight/place_search.h"
#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

// Distance of a point of W from the wish `near`, a side of the object or a point as --near has it,
// in extents of the object `points`; from a point, in half its diagonal. Empty for an empty wish.
// Throws InputError for another word.
std::function<double(const Eigen::Vector3d&)> distance_of(
    const std::string& near, const std::vector<Eigen::Vector3d>& points);

// Effort of a candidate: how easily the arm reaches a place of the surface, and from it the place
// moved by `up`, W [m], where that is not zero. At ease: 0; not: 1.
std::function<double(const SurfaceSample&)> unreachable(
    const Belief& belief, const Pose& X_WP, const PreflightSettings& settings,
    const Eigen::Vector3d& up = Eigen::Vector3d::Zero());

// The surface that the planner knows, in P [m].
std::vector<Eigen::Vector3d> known_points(const Belief& belief, const Pose& X_WP);

// `near`: as distance_of() has it. The belief must outlive the search.
PlaceSearchSettings search_settings(const Scenario& scenario, const Belief& belief,
                                    const Pose& X_WP, const std::string& near);

}  // namespace impedraw

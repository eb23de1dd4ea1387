// Can the arm hold the pen everywhere along the path?
#pragma once

#include <functional>
#include <string>

#include "planning/tip_path.h"

namespace impedraw {

// Why the arm cannot put the tip at p_WD with the pen along −n_WD, and by how much ("23 mm too far"); empty where it can.
// Called in the order of the path, so that it may start from its last answer.
using ReachProblem = std::function<std::string(const Eigen::Vector3d& p_WD, const Eigen::Vector3d& n_WD)>;

// Asks every `step` metres of tip path, and at each stroke's ends. InputError at the first problem: stroke or travel, place, what `problem`
// says.
void require_reach(const TipPath& path, double step, const ReachProblem& problem);

}  // namespace impedraw

// check_transitions() of preflight.h, with its progress told.
#pragma once

#include <functional>
#include <vector>

#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

// `progress`: called now and then with the share of the path's time checked so far.
std::vector<Finding> check_transitions(const TipPath& path,
                                       const std::vector<PlacedStroke>& strokes, ArmModel& arm,
                                       const Canvas* obstacle, const JointVector& start_q,
                                       const PreflightSettings& settings,
                                       const std::function<void(double)>& progress);

}  // namespace impedraw

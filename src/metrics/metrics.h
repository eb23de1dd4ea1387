// metrics.json: a run in numbers, each computed from run.h5 alone.
//
// Samples      pen-down: /stroke ≥ 0. f = force · normal. Ink: f > 0.1 N. First touch:
//              ink/ink_lines.h.
//              SD is the population's; percentiles interpolate linearly; forces are pooled over
//              strokes.
// Keys         in the order of metric_definitions(), then `reasons`: {name: why it is null}. What
//              cannot be computed is null, never 0.
//
// A stroke may be drawn in several passes: each has its own first touch, settling and touchdown;
// ink of all of them covers the target.
//
// coverage counts the target's length, exact, against the ink's own line; gaps are along one
// stroke, and on a closed one may cross its joint. ink_outside interpolates the distance between a
// line's points. An untouched stroke's target counts in coverage as uncovered. real_time_factor
// counts as the loop what of the log was left to write when it ended (wall_loop + wall_writing).
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "impedraw/log/run_data.h"
#include "impedraw/metrics/ink_match.h"

namespace impedraw {

struct MetricDefinition {
  const char* name;
  const char* unit;  // "1": a plain number
  const char* meaning;
};

const std::vector<MetricDefinition>& metric_definitions();

nlohmann::ordered_json compute_metrics(const RunData& run);
nlohmann::ordered_json compute_metrics(const RunData& run,
                                       const InkMatch& drawn);  // `drawn` = match_ink(run)

}  // namespace impedraw

// The order in which strokes are drawn on a canvas that moves, where the planned one does not hold.
//
// Each stroke takes its time, and can be drawn in windows of time alone (reach_windows()). Two
// orders are tried: the planned one, each stroke as early as it can be; and earliest deadline
// first, which takes of the strokes that can be begun the one that will be out of reach soonest.
// The order that leaves out fewer strokes counts; of two equal ones that which ends earlier, the
// planned one unless it costs more than kWorth.
#pragma once

#include <cstddef>
#include <vector>

#include "impedraw/planning/preflight/carried_path.h"

namespace impedraw {

struct StrokeJob {
  double duration = 0.0;             // from the approach to the last point [s]
  std::vector<ReachWindow> windows;  // in order
};

struct StrokeSlot {
  std::size_t job = 0;
  double start = 0.0;  // of its approach [s]
  ReachWindow window;
};

struct StrokeSchedule {
  std::vector<StrokeSlot> slots;  // in order of time
  std::vector<std::size_t> lost;  // jobs that fit nowhere
};

inline constexpr double kWorth = 1.0;  // [s]

// now: earliest start [s]; between: from one stroke's last point to the next one's approach [s].
StrokeSchedule schedule_strokes(const std::vector<StrokeJob>& jobs, double now, double between);

}  // namespace impedraw

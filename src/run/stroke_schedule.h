// The choice of the stroke that is drawn next on a canvas that moves, and of its time.
//
// Each stroke takes its time, and can be drawn in windows of time alone (ReachMap::windows()). Two
// orders are tried: the planned one, each stroke as early as it can be; and earliest deadline
// first, which takes of the strokes that can be begun the one that will be out of reach soonest.
// The order that leaves out fewer strokes counts; of two equal ones that which ends earlier, the
// planned one unless it costs more than kWorth. Pieces of a stroke that adjoin are drawn without a
// lift between them where their windows allow it. What this leaves out is not lost if it can be
// drawn beyond the horizon, too: a window is open there, or opened twice before.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "impedraw/planning/preflight/reach_map.h"

namespace impedraw {

struct StrokeJob {
  double duration = 0.0;                 // from the approach to the last point [s]
  std::vector<ReachWindow> windows;      // in order
  double approach = 0.0;                 // from there to the first point [s]
  bool continues = false;                // it begins where the job before it ends
  std::vector<ReachWindow> behind = {};  // if it continues that without a lift: of its first point
};

struct StrokeSlot {
  std::size_t job = 0;
  double start = 0.0;  // of its approach [s]
  ReachWindow window;
};

struct StrokeSchedule {
  std::vector<StrokeSlot> slots;  // in order of time
  std::vector<std::size_t> lost;  // jobs that fit nowhere
  double end = 0.0;               // of the last stroke [s]
};

struct StrokeChoice {
  StrokeSchedule order;
  std::vector<std::size_t> lost;  // of order.lost: for good
  // The strokes that can be begun now, best first: the first of the order and those that follow it
  // without a wait; then each of those that come later, with what continues it. Empty: the first is
  // to be waited for.
  std::vector<std::vector<std::size_t>> now;
};

inline constexpr double kWorth = 1.0;           // [s]
inline constexpr double kSoon = 0.3;            // a start that is so near is now [s]
inline constexpr std::size_t kMostChoices = 8;  // of StrokeChoice::now

// The earliest slot of a job from `time` on.
std::optional<StrokeSlot> slot_of(const std::vector<StrokeJob>& jobs, std::size_t job, double time);

// now: earliest start [s]; between: from one stroke's last point to the next one's approach [s].
StrokeSchedule schedule_strokes(const std::vector<StrokeJob>& jobs, double now, double between);

// horizon: until when windows were looked for [s]. sure: a verdict is final; else no job is lost.
StrokeChoice choose_strokes(const std::vector<StrokeJob>& jobs, double now, double between,
                            double horizon, bool sure);

}  // namespace impedraw

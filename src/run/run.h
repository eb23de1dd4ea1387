// The control loop: follows an experiment's path with the arm behind a driver (driver.h), and logs
// every step.
//
// After the last stroke, parts that got no ink by the arm's own signals (ink_watch.h) are drawn
// once more, and what still has none is told.
//
// A run that cannot go on lifts the pen before it ends: interrupted, or with a controller whose
// steps come too late. It ends at once where there is no control left: the motion went unstable, or
// the joints' state has been bad for longer than kBadStateTime. What an interrupted run has not
// drawn, a later one can draw (Resumption).
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "impedraw/experiment/experiment.h"
#include "impedraw/log/log.h"
#include "impedraw/run/driver.h"
#include "impedraw/run/ink_watch.h"
#include "impedraw/simulation/world.h"

namespace impedraw {

enum class RunEnd { finished, stopped, interrupted };

struct RunProgress {
  double time;  // of the driver's clock [s]
  int stroke;   // how many strokes of the pass were begun
  int strokes;
  double drawn;   // pen-down length of the pass, on the surface [m]
  double length;  // of all of the pass [m]
  double share;   // of the pass's time
  bool again;     // the pass draws what got no ink in the first one
};

struct RunHooks {
  std::function<void(const RunProgress&)> progress;  // called every ten control steps
  std::function<bool()> interrupted;                 // looked at as often
};

inline constexpr double kBadStateTime = 0.2;  // [s]
inline constexpr double kShortestGap = 1e-3;  // a shorter one is none [m]
// what is drawn again begins and ends that much inside of the ink [m]
inline constexpr double kRedrawOverlap = 1e-3;

struct RunOutcome {
  RunEnd end = RunEnd::finished;
  std::string cause;       // of a stop
  double simulated = 0.0;  // of the driver's clock [s]
  std::map<std::string, double>
      met;  // how long the controller said what of itself: a limit met, an input that was bad [s]
  SolverCutoffs cutoffs;                // of the simulated contact
  std::vector<StrokePart> drawn_again;  // had no ink after the first pass
  std::vector<StrokePart>
      lacking;  // have none now; without those that an interrupted run never came to
  WallTimes wall;
};

// What an earlier run into the same log left: the run goes on from there.
struct Resumption {
  InkWatch ink;       // of its rows
  JointVector q;      // its last posture [rad]
  double time = 0.0;  // the first that is free [s]
};

// The log's; InputError where it is none.
Resumption read_resumption(const Experiment& experiment, const std::filesystem::path& log_file);

// Whether the pen writes, by what the arm itself knows (ink_watch.h): contact state, and measured
// force along the estimated normal [N].
bool writes(const Experiment& experiment, ContactMode mode, double normal_force);

// Drives the arm from where it stands: at the beginning of the plan's path, or for a resumption at
// its last posture. Streams to `log_file`. Throws LogError when the log cannot be written,
// InputError for a driver of another arm, whatever Driver::start() throws. start_up: wall seconds
// already spent [s].
RunOutcome run(Experiment& experiment, Driver& driver, const std::filesystem::path& log_file,
               double start_up, const RunHooks& hooks = {}, const Resumption* resumption = nullptr);

// The same with the simulated arm, which starts where the path does. Pushes and faults of the
// scenario come in the first run, not in one that goes on with it.
RunOutcome run(Experiment& experiment, const std::filesystem::path& log_file, double start_up,
               const RunHooks& hooks = {}, const Resumption* resumption = nullptr);

}  // namespace impedraw

// Runs an experiment at 1 kHz of simulated time and logs every step.
//
// A run that cannot go on lifts the pen before it ends: interrupted, or with a controller whose steps come too late. It ends at once where
// there is no control left: the motion went unstable, or the joints' state has been bad for longer than kBadStateTime.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "app/experiment.h"
#include "report/log.h"

namespace impedraw {

enum class RunEnd { finished, stopped, interrupted };

struct RunProgress {
  double time;      // simulated [s]
  double duration;  // of the plan [s]
  int stroke;       // counted from 1; 0 before the first
  int strokes;
  double share;     // of the plan's time
};

struct RunHooks {
  std::function<void(const RunProgress&)> progress;  // called every 10 ms of simulated time
  std::function<bool()> interrupted;                 // looked at as often
};

inline constexpr double kBadStateTime = 0.2;  // [s]

struct RunOutcome {
  RunEnd end = RunEnd::finished;
  std::string cause;       // of a stop
  double simulated = 0.0;  // [s]
  std::map<std::string, double> met;  // how long the controller said what of itself: a limit met, an input that was bad [s]
  WallTimes wall;
};

// Streams to `log_file`. Throws LogError when the log cannot be written. start_up: wall seconds already spent [s].
RunOutcome run(Experiment& experiment, const std::filesystem::path& log_file, double start_up, const RunHooks& hooks = {});

}  // namespace impedraw

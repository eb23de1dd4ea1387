// How a run ended: one value for log, metrics.json, page, Python and terminal.
//
// run.h5 keeps how its loop ended, and what was given up on the way, in its root attribute `ending`
// (JSON). A loop that came to its end may still have drawn nothing, or far off: compute_metrics()
// judges that from the rows (judged()).
#pragma once

#include <map>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace impedraw {

enum class RunEnd {
  finished,
  stopped,        // halted by a fault, a fence, a watchdog or an emergency stop
  interrupted,    // stopped by a person, or by a signal; the pen was lifted
  nothing_drawn,  // went to its end, with next to no ink
  far_off,        // went to its end, with ink far from where it should be
  unknown,        // killed, or the log is of an older version
};
// "nothing_drawn"
const char* name_of(RunEnd end) noexcept;

struct Ending {
  RunEnd end = RunEnd::finished;
  std::string cause{};  // one sentence without its full stop; empty: finished
  // File in the run's folder with the last seconds of a run that was halted.
  std::string incident{};
  // What was given up while drawing, by reason: length in the drawing plane [m].
  std::map<std::string, double> given_up{};
};

inline constexpr const char* kIncidentFile = "incident.html";  // of Ending::incident

// Text of the attribute (kEndingAttribute, log/log.h).
std::string ending_text(const Ending& ending);
Ending read_ending(const std::map<std::string, std::string>& attributes);

// For people: "stopped by a person: interrupted at t = 3.210 s; the pen was lifted".
std::string told(const Ending& ending);

struct Metrics;  // metrics.h
// The same ending, unless it finished and the metrics say that nothing was drawn, or far off: less
// than kLeastDrawn of what was promised has ink, or ink or path are more than kFarOff away (RMS).
// `asks_ink`: false for a dry run.
Ending judged(Ending ending, const Metrics& metrics, bool any_ink, bool asks_ink);
inline constexpr double kLeastDrawn = 0.01;
inline constexpr double kFarOff = 5.0;  // [mm]

}  // namespace impedraw

// The end of a run, what was promised of its drawing, and the share of that which was drawn.
#pragma once

#include <map>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "impedraw/log/run_data.h"

namespace impedraw {

// The end of a run: one value for log, metrics.json, page, Python and terminal.
//
// run.h5 keeps how its loop ended, and what was given up on the way, in its root attribute `ending`
// (JSON). A loop that came to its end may still have drawn nothing, or far off: compute_metrics()
// judges that from the rows (judged()).

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
  // Length that was given up while drawing, in the drawing plane, by reason [m].
  std::map<std::string, double> given_up{};
};

inline constexpr const char* kIncidentFile = "incident.html";  // of Ending::incident

// Text of the attribute (kEndingAttribute, log/log.h).
std::string ending_text(const Ending& ending);
Ending read_ending(const std::map<std::string, std::string>& attributes);

// For people: "stopped by a person: interrupted at t = 3.210 s; the pen was lifted".
std::string told(const Ending& ending);

struct Metrics;  // metrics.h
struct Promise;
// The same ending, unless it finished and the metrics say that nothing was drawn, or far off: less
// than kLeastDrawn of what was promised has ink, or ink or path are more than kFarOff away (RMS).
Ending judged(Ending ending, const Metrics& metrics, bool any_ink, const Promise& promise);
inline constexpr double kLeastDrawn = 0.01;
inline constexpr double kFarOff = 5.0;  // [mm]

// The pre-flight's promise of a drawing, as the log keeps it: the root attribute `promise` of
// run.h5, JSON. Without it (older logs), metrics that need it are null.
struct Promise {
  // Lengths are in the drawing plane, of a wrapped drawing those before it was wrapped [m]. Of the
  // artwork, hatched and dashed: `asked`. Of the parts that are drawn: `promised`. Of those which
  // the pre-flight names with a reason: `undrawable`. Neither promised nor named: `unnamed`, 0 but
  // for rounding or a fault.
  double asked = 0.0, promised = 0.0, undrawable = 0.0, unnamed = 0.0;
  double flat = 1.0;  // `promised` as a multiple of the plan's strokes in the plane: of a wrap
  // The length that a planner that knows the true canvas could draw: all that lies above it where
  // it leans by less than 75°, but for what the arm cannot reach. None if wrapped, and in older
  // logs.
  std::optional<double> reachable;
  std::map<std::string, int> problems;    // findings by problem: {"too_steep", 3}
  std::map<std::string, double> lengths;  // of them; empty in older logs [m]
  double slope = 0.0;                     // steepest under the target, against the level [rad]
  double time = 0.0;                      // of the planned path [s]
  bool asks_ink = true;                   // false: a dry run
  double face = 0.0;  // radius of a pad, whose pressure may have its middle beside the line [m]
  Eigen::Vector3d axis_W = Eigen::Vector3d::UnitZ();  // the drawing axis, out of the canvas
};

inline constexpr const char* kPromiseAttribute = "promise";

std::string promise_text(const Promise& promise);
std::optional<Promise> read_promise(const std::map<std::string, std::string>& attributes);

// The drawn share of a drawing, and the reasons for the rest. Lengths are in the drawing plane.
//
// Drawn: where a row has ink, whatever its place. Gaps of up to 1 mm count as drawn. The rest is,
// by reason, what the pre-flight left out (names of Problem), what was given up while drawing
// (Ending::given_up), and what has no ink: `not_reached` where the run was broken off, else
// `no_ink`.
struct DrawnLengths {
  double asked = 0.0, drawn = 0.0;          // [m]
  std::map<std::string, double> not_drawn;  // by reason [m]
};

DrawnLengths drawn_lengths(const RunData& run, const Promise& promise, const Ending& ending);

// "edge 0.2 m, too steep 31 mm", the longest first; empty: nothing is missing.
std::string rest_text(const std::map<std::string, double>& not_drawn_mm);
// "31 mm", "2.9 m".
std::string length_text(double mm);

}  // namespace impedraw

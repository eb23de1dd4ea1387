// Decides what to draw next on a canvas that moves: the pre-flight over the envelope of its motion.
//
// The strokes are known in the canvas's frame K; where K will be is forecast from what has been
// estimated (canvas_forecast.h). Before the first stroke, and again before each one, the plan is
// checked where the canvas will be while it is followed (carried_path.h), kHorizon ahead. Where the
// planned order holds, it is drawn. Where it does not, each stroke's windows of reach are found and
// the strokes are put in another order (carried_plan.h); the pen waits, up and at rest in W,
// until the next one comes into reach. What fits nowhere is cut, down to kShortest, and then named,
// with when and how far; unless it comes into reach again and again, or still does at the horizon.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/experiment/experiment.h"
#include "impedraw/perception/canvas_forecast.h"
#include "impedraw/planning/preflight/carried_path.h"
#include "impedraw/planning/stroke_part.h"

namespace impedraw {

// The order in which strokes are drawn on a canvas that moves, where the planned one does not hold.
//
// Each stroke takes its time, and can be drawn in windows of time alone (reach_windows()). Two
// orders are tried: the planned one, each stroke as early as it can be; and earliest deadline
// first, which takes of the strokes that can be begun the one that will be out of reach soonest.
// The order that leaves out fewer strokes counts; of two equal ones that which ends earlier, the
// planned one unless it costs more than kWorth.
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

// A part that cannot be drawn, as the canvas moves.
struct UnreachedPart {
  StrokePart part;   // piece of a promised stroke
  std::string text;  // "stroke 5 leaves the arm's reach at t = 12.3 s: 0.14 m short"
};

struct CarriedDecision {
  enum class Kind {
    draw,     // follow `path`
    wait,     // be up and at rest until `until`, then decide again
    nothing,  // no stroke is left that can be drawn
  } kind = Kind::nothing;
  TipPath path;                   // in K
  std::vector<StrokePart> parts;  // parts that the path draws, in its order
  double join = 0.0;              // a pen at rest goes over to the path within this time [s]
  double until = 0.0;             // [s]
  std::optional<Eigen::Vector3d> place_W;  // where to wait; nothing: where the pen is [m]
  std::string why;                         // reason for not drawing as planned
  std::vector<UnreachedPart> lost;         // parts given up for good
  std::vector<StrokePart> too_long;        // parts that fit nowhere as a whole: to be cut first
  std::vector<StrokePart> in_vain;         // parts that were tried now: others first, next time
  std::vector<std::string> remarks;        // "stroke 3 is in reach from 4.2 to 9.8 s"
};

// State of the pen at the time of the decision.
struct CarriedPen {
  double time = 0.0;  // by the driver's clock [s]
  Pose X_WE, X_WK;    // X_WK: as estimated now
  JointVector q;
  bool joined = false;  // the pen moves with the canvas; else it rests in W
};

class CarriedPlan {
 public:
  static constexpr double kHorizon = 40.0;  // [s]
  static constexpr double kSure = 3.0;      // explained motion after which a verdict is final [s]
  static constexpr double kShortest = 0.1;  // what fits nowhere and is longer is to be cut [m]

  // first_time: when the run began, for messages [s].
  CarriedPlan(const Experiment& experiment, double first_time);

  // parts: what shall be drawn, in the planned order. Takes some milliseconds for each stroke.
  CarriedDecision decide(const std::vector<StrokePart>& parts, const CanvasForecast& forecast,
                         const CarriedPen& pen);

  // Returns true if the path's next stroke can still be drawn; `planned`: the path's time [s].
  bool holds(const TipPath& path, double planned, const CanvasForecast& forecast,
             const CarriedPen& pen);

  // The artwork's number of a promised stroke.
  int number_of(int stroke) const;

 private:
  TipPath plan(const std::vector<StrokePart>& parts, const Eigen::Vector3d& p_K,
               const Eigen::Vector3d& n_K, double hold) const;
  std::optional<CarriedFault> fault(const TipPath& path, const CanvasForecast& forecast,
                                    const CarriedPen& pen, double join) const;
  std::string lost_text(const StrokePart& part, std::optional<CarriedFault> fault_of_it,
                        const StrokeJob& job, const CanvasForecast& forecast,
                        const CarriedPen& pen) const;
  std::string fault_text(int stroke, const CarriedFault& fault) const;

  const Experiment& e_;
  double first_time_;
  PreflightSettings checks_;
};

}  // namespace impedraw

// Decides what to draw next on a canvas that moves: the pre-flight over the envelope of its motion.
//
// The strokes are known in the canvas's frame K; where K will be is forecast (canvas_forecast.h).
// Before the first stroke, and again before each one, the plan is checked where the canvas will be
// while it is followed (carried_path.h), kHorizon ahead. Where the planned order does not hold,
// each stroke's windows of reach are found (reach_map.h), and another order (stroke_schedule.h);
// the pen waits, up and at rest in W, until the next stroke comes into reach. What fits nowhere is
// cut, down to kShortest, and then named, with when and how far.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "impedraw/experiment/experiment.h"
#include "impedraw/perception/canvas_forecast.h"
#include "impedraw/planning/preflight/carried_path.h"
#include "impedraw/planning/preflight/reach_map.h"
#include "impedraw/planning/stroke_part.h"
#include "impedraw/run/stroke_schedule.h"

namespace impedraw {

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
  static constexpr double kHorizon = 40.0;   // [s]
  static constexpr double kSure = 3.0;       // explained motion after which a verdict is final [s]
  static constexpr double kShortest = 0.05;  // what fits nowhere and is longer is to be cut [m]

  // first_time: when the run began, for messages [s].
  CarriedPlan(const Experiment& experiment, double first_time);

  // parts: what shall be drawn, in the planned order. Takes some milliseconds for each stroke.
  CarriedDecision decide(const std::vector<StrokePart>& parts, const CanvasForecast& forecast,
                         const CarriedPen& pen);

  // Returns true if the path's next stroke can still be drawn; `planned`: the path's time [s].
  bool holds(const TipPath& path, double planned, const CanvasForecast& forecast,
             const CarriedPen& pen);

  // The reason that a part cannot be drawn from where the pen is.
  std::string reason(const StrokePart& part, const CanvasForecast& forecast,
                     const CarriedPen& pen) const;

  // The artwork's number of a promised stroke.
  int number_of(int stroke) const;

 private:
  struct Outlook;

  TipPath plan(const std::vector<StrokePart>& parts, const Eigen::Vector3d& p_K,
               const Eigen::Vector3d& n_K, double hold) const;
  std::optional<CarriedFault> fault(const TipPath& path, const CanvasForecast& forecast,
                                    const CarriedPen& pen, double join) const;
  void look_ahead(const TipPath& planned, Outlook* ahead);
  TipPath from_here(const std::vector<StrokePart>& parts, const CarriedPen& pen) const;
  std::vector<UnreachedPart> named(const std::vector<std::size_t>& lost,
                                   const Outlook& ahead) const;
  void wait_near(const StrokeSlot& slot, const Outlook& ahead, CarriedDecision* out) const;
  bool lay(std::vector<std::size_t> jobs, const Outlook& ahead, CarriedDecision* out) const;
  std::string fault_text(int stroke, const CarriedFault& fault) const;
  std::string window_text(const ReachWindow& window) const;

  const Experiment& e_;
  double first_time_;
  PreflightSettings checks_;
  ReachMap reach_;
};

}  // namespace impedraw

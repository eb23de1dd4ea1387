// A drawing task: decides the next move of the pen from the situation that the last one left.
//
// The three drawings of drawings.h differ in nothing else.
// They know neither driver nor control loop.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "impedraw/control/canvas_estimate.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/perception/canvas_belief.h"
#include "impedraw/perception/canvas_forecast.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/run/carried_plan.h"
#include "impedraw/run/control_loop.h"
#include "impedraw/run/driver.h"
#include "impedraw/run/plan_clock.h"
#include "impedraw/run/remaining.h"

namespace impedraw {

// The search for a surface that is found by touch, along one stroke after the other.
//
// A stroke is planned on a level, whose height is a guess. Once the pen is down, the plan is moved
// to where the tip is. Its clock waits while the pen searches. A search that takes longer than the
// approach over its whole way gives the stroke up.

// Places where a drawing has touched its surface, so that the pen may come down fast elsewhere.
//
//   level(x, y) = min( top, min_i ( z_i + kMargin + kSteepest |p_i − (x, y)| ) )
//
// with the touched points i. It lies above a surface that is nowhere steeper than kSteepest from
// them on. Points are in the drawing frame P.

class TouchedHeights {
 public:
  static constexpr double kMargin = 5e-3;   // [m]
  static constexpr double kSteepest = 1.0;  // rise over run: 45°
  static constexpr double kSpacing = 2e-3;  // between kept points along the path [m]
  static constexpr std::size_t kMost = 50000;

  // top: no part of the surface is higher [m].
  explicit TouchedHeights(double top) : top_(top) { points_.reserve(kMost); }

  // Allocates nothing. Ignores points that are too near to the last one, or one too many.
  void add(const Eigen::Vector3d& p_P) noexcept {
    if (points_.size() == kMost) return;
    if (!points_.empty() && (points_.back() - p_P).head<2>().norm() < kSpacing) return;
    points_.push_back(p_P);
  }
  double level(double x, double y) const noexcept;
  std::size_t size() const { return points_.size(); }

 private:
  double top_;
  std::vector<Eigen::Vector3d> points_;
};

// Time limit for an approach to find the surface [s].
double longest_search(const ImpedanceSettings& control);

class TouchSearch {
 public:
  explicit TouchSearch(const Experiment& experiment);

  void begin_stroke() noexcept { height_ = searched_ = 0.0; }

  // The plan's reference, moved to the touched height. `mode`: of the last cycle.
  TipReference at_touched_height(TipReference reference, ContactMode mode,
                                 const Eigen::Vector3d& p_WE) noexcept;

  // After a cycle. False: there is no surface where it may be. `pen`: the deviation for the clock.
  bool update(const PathSample& desired, const ImpedanceTorque& out, const ControlLoop& loop,
              PenDeviation* pen) noexcept;

  const TouchedHeights& heights() const noexcept { return heights_; }

 private:
  const ImpedanceSettings& control_;
  Pose X_PW_;
  double lowest_;  // no part of the surface is lower, in P [m]
  TouchedHeights heights_;
  double height_ = 0.0;    // tip above the plan [m]
  double searched_ = 0.0;  // [s]
};

// The end of the last path.
struct PathEnd {
  std::optional<StrokePart> blocked;    // it was given up before this place
  bool left_reach = false;              // the canvas took the pen where the arm cannot follow
  bool lost_canvas = false;             // no camera knew where the canvas was
  std::size_t strokes_followed = 0;     // the plan went along so many to their ends
  std::optional<Eigen::Vector3d> felt;  // Kind::feel: where the tip pressed, in W [m]
};

// The situation in which a task decides.
struct Situation {
  CarriedPen pen;
  CanvasStatus canvas;           // status of its estimate
  const CanvasBelief* belief;    // belief about the canvas's motion; null: no camera follows it
  const CanvasHistory& history;  // recent poses of the canvas
  const InkWatch& ink;
  PathEnd last;

  Pose X_KE() const { return pen.X_WK.inverse() * pen.X_WE; }
};

// A stroke among those of a surface that is found by touch: its path ends when the pen is to be
// lifted.
struct TouchedStroke {
  TouchSearch* search;
  int before, all;  // strokes
};

struct Move {
  enum class Kind {
    draw,   // follow `path`
    lift,   // go up, clear of the canvas, and rest in W
    go_to,  // from rest to rest in W, to place_W until `until`; the pen turns to normal_W, if given
    wait,   // rest in W until `until`
    ask,    // the same, and until a person who was told `asks` lets the run go on
    feel,   // down along the pen until something presses, by `depth` at most; then rest in W
    end,    // the drawing is complete, or ends for `cause`
  } kind = Kind::end;
  TipPath path;                        // in K
  bool again = false;                  // it redraws what got no ink
  double join = 0.0;                   // a pen at rest goes over to K within this time [s]
  std::optional<TouchedStroke> touch;  // nothing: the surface is perceived
  // Asked between the strokes of the path, with the plan's time: false ends it there. May be empty.
  std::function<bool(const Situation&, const TipPath&, double planned)> holds;
  // Asked once the last stroke of a path on a canvas that moves is drawn: true if none remains.
  std::function<bool(const InkWatch&)> complete;
  double until = 0.0;                                 // [s]
  const char* waits_for = nullptr;                    // for people
  Eigen::Vector3d place_W = Eigen::Vector3d::Zero();  // [m]
  std::optional<Eigen::Vector3d> normal_W;
  std::optional<HeldPen> pen;  // the arm holds it from here on
  std::string asks;
  double depth = 0.0;  // [m]
  std::string cause;   // empty: finished
};

// Record of a drawing, for the run's outcome.
struct DrawingRecord {
  std::vector<StrokePart> drawn_again;  // parts without ink after the first pass
  std::vector<StrokePart> walls;        // blocked places, which are not drawn again
  // On a canvas that moves: parts out of reach, with when and how far; and notes on strokes that
  // were reordered or waited for.
  std::vector<UnreachedPart> unreached;
  std::vector<std::string> remarks;
  // Motions of the canvas that nobody would notice (CanvasBelief::open_text()).
  std::string canvas_open;
};

class DrawingTask {
 public:
  virtual ~DrawingTask() = default;
  // Takes some milliseconds for each stroke: the arm rests meanwhile.
  virtual Move next(const Situation& situation) = 0;
  virtual DrawingRecord record() const = 0;
};

}  // namespace impedraw

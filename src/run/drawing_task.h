// A drawing task: decides the next move of the pen from the situation that the last one left.
//
// A drawing on a surface that stands (standing_drawing.h), one on a surface that is found by touch
// (touched_drawing.h), and one on a canvas that moves (moving_drawing.h) differ in nothing else.
// They know neither driver nor control loop.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/control/canvas_estimate.h"
#include "impedraw/perception/canvas_belief.h"
#include "impedraw/perception/canvas_forecast.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/run/carried_plan.h"
#include "impedraw/run/held_pen.h"
#include "impedraw/run/ink_watch.h"
#include "impedraw/run/touch_search.h"

namespace impedraw {

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

// Three drawings: on a surface that stands, on one that is found by touch, on a canvas that moves.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/drawing_task.h"
#include "impedraw/run/remaining.h"

namespace impedraw {

// A drawing on a surface that stands and is perceived: the whole plan as one path.
//
// A path that is blocked goes on behind the blocked place (remaining.h). What then has no ink
// is drawn once more.
class StandingDrawing : public DrawingTask {
 public:
  // `first`: the path of the first pass, which keeps off what is blocked.
  StandingDrawing(const Experiment& experiment, TipPath first, BlockedPlaces blocked = {});
  // The pen presses on the canvas, where an earlier run was killed: it goes up before the sensor is
  // tared, and draws what is `left`.
  StandingDrawing(const Experiment& experiment, std::vector<StrokePart> left);

  Move next(const Situation& situation) override;
  DrawingRecord record() const override;

 private:
  Move draw(TipPath path) const;

  const Experiment& e_;
  TipPath first_;
  TipReference end_;  // end of the first path
  bool rises_ = false, begun_ = false, again_ = false;
  std::vector<StrokePart> left_, drawn_again_;
  BlockedPlaces blocked_;
};

// A drawing on a surface that is found by touch: stroke by stroke, each on a level of its own above
// the heights that were touched so far.
class TouchedDrawing : public DrawingTask {
 public:
  TouchedDrawing(const Experiment& experiment, std::vector<PlacedStroke> strokes);

  Move next(const Situation& situation) override;
  DrawingRecord record() const override;

 private:
  const Experiment& e_;
  std::vector<PlacedStroke> strokes_;  // strokes of this pass
  std::size_t next_ = 0;               // stroke; strokes_.size(): the pen goes up
  bool again_ = false;
  std::vector<StrokePart> drawn_again_;
  TouchSearch search_;
};

// A drawing on a canvas that moves: what is drawn, and when, is decided by a forecast of its motion
// (carried_plan.h).
//
// The arm first rests while the cameras watch the canvas. The pen waits, up and at rest, for a
// stroke to come into reach; after kMostWait the stroke is given up. One that fits nowhere as a
// whole is cut, and its parts likewise. A stroke during which the canvas leaves the reach is given
// up after kMostLeft attempts.
class MovingDrawing : public DrawingTask {
 public:
  static constexpr double kMostWait = 45.0;  // [s]
  static constexpr int kMostLeft = 3;
  static constexpr int kMostLosses = 20;  // losses of the canvas in one pass

  // first_time: of the run, where an earlier one left off [s].
  MovingDrawing(const Experiment& experiment, double first_time);

  Move next(const Situation& situation) override;
  DrawingRecord record() const override;

 private:
  enum class Stage { begin, raised, watched, decide, risen, waited, drawn };

  // Each takes in what the last move did. Nothing: decide what comes next.
  std::optional<Move> end_of_watch(const Situation& now);
  std::optional<Move> end_of_wait(const Situation& now);
  std::optional<Move> end_of_path(const Situation& now);

  Move decide(const Situation& now);
  Move draw(CarriedDecision decision);
  Move wait(const Situation& now);
  CarriedDecision decision_for(const std::vector<StrokePart>& parts, const Situation& now);
  CanvasForecast forecast(const Situation& now) const;
  void begin_pass(std::vector<StrokePart> parts);
  std::vector<StrokePart> left_by(const InkWatch& ink) const;
  // Cuts each of the pending parts that are given in two or more.
  void cut(const std::vector<StrokePart>& parts);
  // Leaves them out; or the end of the drawing, where it must be drawn as a whole.
  std::optional<Move> give_up(const std::vector<UnreachedPart>& lost);
  void remark_on(const std::string& remark);

  const Experiment& e_;
  CarriedPlan plan_;
  double first_time_;
  Stage stage_ = Stage::begin;  // what the last move was for
  bool again_ = false;
  std::vector<StrokePart> pending_;  // in this pass
  CarriedDecision decision_;         // the last one
  BlockedPlaces blocked_;
  DrawingRecord record_;
  double wait_began_ = 0.0;  // [s]
  double waited_ = 0.0;      // since a path was begun [s]
  int losses_ = 0;           // losses of the canvas in this pass
  int left_reach_ = 0;       // times that the canvas took the pen out of reach
};

}  // namespace impedraw

// A drawing with several pens (`pens` of the scenario), one after the other. Each draws its
// strokes, and once more what got no ink, before a person puts in the next one:
//
//   draw ─> up ─> pen.place ─> a person ─> rest, a new tare ─> pen.spot ─> pen.place ─> draw …
//
// The check of a pen's length, where pen.check asks for it. The arm presses the tip on the same
// spot, with the same axis and force, as the first pen did before it drew. With s = n · p_WE of the
// model's tip there, of a pen that is believed to be L longer than that of arm.urdf,
//   L' = L + s − s_1.
// Errors that the touches share cancel: those of the arm's model, of the seen surface, and the give
// of tip and canvas. The first pen is as it is believed to be; with pen.spot given, the spot is
// known, and the first pen is checked, too.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/drawing_task.h"
#include "impedraw/run/driver.h"

namespace impedraw {

// The pen of that number, as far as the scenario knows it.
HeldPen pen_of(const Experiment& experiment, int number);
// The number of the pen that draws a stroke of the plan.
int pen_of_stroke(const Experiment& experiment, int stroke);
// True if a plan needs more than one pen, or one that is not as arm.urdf and control.tip have it.
bool needs_pens(const Experiment& experiment);

class PenChanges : public DrawingTask {
 public:
  // A pen's drawing of these parts, from a tip at p_WE with the normal n_W, after a rest [s].
  using DrawingMaker = std::function<std::unique_ptr<DrawingTask>(
      std::vector<StrokePart> parts, const Eigen::Vector3d& p_WE, const Eigen::Vector3d& n_W,
      double rest)>;

  // Takes the rest of the plan's strokes; the pen that is in, which draws first; and X_WE, the
  // pose of arm.urdf's tip. Plans all: while the arm is driven, only paths of gaps are planned.
  PenChanges(const Experiment& experiment, std::vector<StrokePart> left, const HeldPen& in,
             const Pose& X_WE, const DrawingMaker& make);

  Move next(const Situation& situation) override;
  DrawingRecord record() const override;

 private:
  struct Turn {
    int pen;
    std::vector<StrokePart> parts;
    std::unique_ptr<DrawingTask> drawing;
  };
  using Step = std::function<Move(const Situation&)>;

  void begin_turn();
  void begin_check();
  Move found(const Situation& situation);
  Step go(const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W) const;
  Step go_up() const;
  Step rest() const;
  // As the drawing of a pen sees it: the strokes of the others have ink.
  InkWatch ink_of(const Turn& turn, const InkWatch& ink) const;
  std::string name_of(int pen) const;

  const Experiment& e_;
  HeldPen in_;
  Eigen::Vector3d axis_W_, place_W_;
  bool checks_, checks_first_;
  std::optional<Pose> spot_;  // its z axis is the normal
  std::vector<Turn> turns_;
  std::size_t turn_ = 0;
  bool begun_ = false;  // the turn's steps are made
  std::deque<Step> steps_;
  std::vector<std::string> remarks_;
};

}  // namespace impedraw

// A drawing on a surface that stands and is perceived: the whole plan as one path.
//
// A path that is blocked goes on behind the blocked place (blocked_places.h). What then has no ink
// is drawn once more.
#pragma once

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/blocked_places.h"
#include "impedraw/run/drawing_task.h"

namespace impedraw {

class StandingDrawing : public DrawingTask {
 public:
  // `first`: the path of the first pass.
  StandingDrawing(const Experiment& experiment, TipPath first);

  Move next(const Situation& situation) override;
  DrawingRecord record() const override;

 private:
  Move draw(TipPath path) const;
  Move draw_again(const Situation& situation);

  const Experiment& e_;
  TipPath first_;
  TipReference end_;  // end of the first path
  bool begun_ = false, again_ = false;
  std::vector<StrokePart> drawn_again_;
  BlockedPlaces blocked_;
};

}  // namespace impedraw

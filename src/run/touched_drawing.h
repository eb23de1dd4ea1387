// A drawing on a surface that is found by touch: stroke by stroke, each on a level of its own above
// the heights that were touched so far.
#pragma once

#include <cstddef>

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/drawing_task.h"

namespace impedraw {

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

}  // namespace impedraw

#include "impedraw/run/touched_drawing.h"

#include <utility>

#include "impedraw/experiment/height_sources.h"
#include "impedraw/run/remaining.h"

namespace impedraw {

TouchedDrawing::TouchedDrawing(const Experiment& e, std::vector<PlacedStroke> strokes)
    : e_(e), strokes_(std::move(strokes)), search_(e) {}

Move TouchedDrawing::next(const Situation& now) {
  Move move;
  const Pose& X_WE = now.pen.X_WE;
  if (next_ > strokes_.size()) {
    if (again_ || !e_.scenario.drawing.redraw) return move;
    again_ = true;
    drawn_again_ = remaining(e_, now.ink);
    if (drawn_again_.empty()) return move;
    strokes_ = strokes_of(e_, drawn_again_);
    next_ = 0;
  }
  if (next_ == strokes_.size()) {
    move.kind = Move::Kind::lift;
  } else {
    const PlacedStroke& stroke = strokes_[next_];
    const Eigen::Vector2d first = stroke.p_P.front();
    const double hold = next_ == 0 && !again_ ? e_.plan.path_settings.start_hold : 0.0;
    move.kind = Move::Kind::draw;
    move.path = plan_from(e_.plan.path_settings,
                          level_surface(search_.heights().level(first.x(), first.y())), {stroke},
                          X_WE.p, -X_WE.R.col(2), hold);
    move.again = again_;
    move.touch = {&search_, static_cast<int>(next_), static_cast<int>(strokes_.size())};
  }
  ++next_;
  return move;
}

DrawingRecord TouchedDrawing::record() const {
  DrawingRecord record;
  record.drawn_again = drawn_again_;
  return record;
}

}  // namespace impedraw

#include "impedraw/run/standing_drawing.h"

#include <utility>

#include "impedraw/run/remaining.h"

namespace impedraw {

StandingDrawing::StandingDrawing(const Experiment& e, TipPath first)
    : e_(e), first_(std::move(first)), end_(first_.at(first_.duration()).reference) {}

Move StandingDrawing::next(const Situation& now) {
  if (!std::exchange(begun_, true)) return draw(std::move(first_));
  if (now.last.blocked && !blocked_.full()) {
    blocked_.add(*now.last.blocked);
    std::optional<TipPath> around = path_around(e_, now.pen.q, now.X_KE(), now.ink, &blocked_);
    if (around) return draw(std::move(*around));
  }
  const bool once = e_.scenario.drawing.dry_run || !e_.scenario.drawing.redraw;
  return again_ || once ? Move{} : draw_again(now);
}

Move StandingDrawing::draw_again(const Situation& now) {
  again_ = true;
  drawn_again_ = remaining(e_, now.ink, blocked_.parts());
  if (drawn_again_.empty()) return {};
  const Pose X_KE = now.X_KE();
  const bool at_end = blocked_.parts().empty();
  TipPath path = path_without_misses(e_, &drawn_again_, at_end ? end_.p_WD : X_KE.p,
                                     at_end ? end_.n_WD : Eigen::Vector3d(-X_KE.R.col(2)), 0.0,
                                     &now.pen.q);
  return drawn_again_.empty() ? Move{} : draw(std::move(path));
}

Move StandingDrawing::draw(TipPath path) const {
  Move move;
  move.kind = Move::Kind::draw;
  move.path = std::move(path);
  move.again = again_;
  return move;
}

DrawingRecord StandingDrawing::record() const {
  DrawingRecord record;
  record.drawn_again = drawn_again_;
  record.walls = blocked_.parts();
  return record;
}

}  // namespace impedraw

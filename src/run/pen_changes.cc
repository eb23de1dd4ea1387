#include "impedraw/run/pen_changes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "impedraw/common/rotations.h"
#include "impedraw/simulation/describe_world.h"

namespace impedraw {
namespace {

constexpr double kAboveSpot = 0.03;  // of the spot, where the way down begins [m]
constexpr double kBeneath = 0.025;   // of the spot, where it ends without a touch [m]
constexpr double kTurnRate = 0.5;    // of the pen's axis, at most [rad/s]
constexpr double kLeast = 0.5;       // of a way [s]

std::size_t index(int i) { return static_cast<std::size_t>(i); }

}  // namespace

HeldPen pen_of(const Experiment& e, int number) {
  HeldPen pen{number, 0.0, e.control.impedance.tip.radius, {}};
  if (number < 0) return pen;
  const LayerPenSettings& given = e.scenario.pens[index(number)];
  pen.longer = given.longer.value_or(pen.longer);
  pen.radius = given.radius.value_or(pen.radius);
  return pen;
}

int pen_of_stroke(const Experiment& e, int stroke) {
  return e.plan.pens ? e.plan.pens->of(stroke).number : -1;
}

bool needs_pens(const Experiment& e) {
  const HeldPen plain = pen_of(e, -1), first = pen_of(e, pen_of_stroke(e, 0));
  if (first.longer != plain.longer || first.radius != plain.radius) return true;
  for (std::size_t i = 0; i < e.plan.strokes.size(); ++i)
    if (pen_of_stroke(e, static_cast<int>(i)) != first.number) return true;
  return e.scenario.pen.check && e.scenario.pen.spot;
}

PenChanges::PenChanges(const Experiment& e, std::vector<StrokePart> left, const HeldPen& in,
                       const Pose& X_WE, const DrawingMaker& make)
    : e_(e),
      in_(in),
      axis_W_(e.artwork.X_WP.R.col(2)),
      place_W_(e.scenario.pen.place.value_or(e.scenario.arm.start_p_WE)),
      checks_(e.scenario.pen.check && touches(e.scenario)),
      checks_first_(checks_ && !in.spot) {
  // After a run that was ended early, gaps of earlier pens may be left: what is in draws first.
  const auto by_it = [&](const StrokePart& part) {
    return pen_of_stroke(e, part.stroke) == in.number;
  };
  const auto begin = std::ranges::find_if(left, by_it);
  std::rotate(left.begin(), begin, std::find_if_not(begin, left.end(), by_it));
  for (const StrokePart& part : left) {
    const int pen = pen_of_stroke(e, part.stroke);
    if (turns_.empty() || turns_.back().pen != pen) turns_.push_back({pen, {}, {}});
    turns_.back().parts.push_back(part);
  }
  if (e.scenario.pen.spot) {
    spot_ = Pose{*e.scenario.pen.spot, e.artwork.X_WP.R};
    if (!in_.spot) in_.spot = axis_W_.dot(spot_->p);
  } else if (checks_ && !e.plan.strokes.empty()) {
    const Eigen::Vector2d& first = e.plan.strokes.front().p_P.front();
    if (const SurfaceHeight::Sample there = e.surface()(first.x(), first.y())) {
      const Eigen::Quaterniond upright = turn_between(Eigen::Vector3d::UnitZ(), there->n_P);
      spot_ = e.artwork.X_WP * Pose{there->p_P, upright.toRotationMatrix()};
    }
  }
  const bool changes =
      std::ranges::any_of(turns_, [&](const Turn& turn) { return turn.pen != in.number; });
  checks_ = checks_ && spot_ && (changes || e.scenario.pen.spot);
  checks_first_ = checks_first_ && checks_;
  for (Turn& turn : turns_) {
    if (&turn == &turns_.front() && turn.pen == in_.number && !checks_first_)
      turn.drawing = make(turn.parts, X_WE.p + in_.longer * X_WE.R.col(2), -X_WE.R.col(2),
                          e.plan.path_settings.start_hold);
    else
      turn.drawing = make(turn.parts, place_W_, axis_W_, 0.0);
  }
}

Move PenChanges::next(const Situation& now) {
  while (turn_ < turns_.size()) {
    if (!std::exchange(begun_, true)) begin_turn();
    if (!steps_.empty()) {
      const Step step = std::move(steps_.front());
      steps_.pop_front();
      return step(now);
    }
    const InkWatch ink = ink_of(turns_[turn_], now.ink);
    Move move =
        turns_[turn_].drawing->next({now.pen, now.canvas, now.belief, now.history, ink, now.last});
    if (move.kind != Move::Kind::end || !move.cause.empty()) return move;
    ++turn_;
    begun_ = false;
  }
  return {};
}

// The steps to the turn's drawing.
void PenChanges::begin_turn() {
  const int pen = turns_[turn_].pen;
  const bool change = pen != in_.number, first = turn_ == 0 && (change || checks_first_);
  if (first) steps_.push_back(rest());
  if (change) {
    steps_.push_back(go_up());
    steps_.push_back(go(place_W_, axis_W_));
    steps_.push_back([this, pen](const Situation& now) {
      const std::optional<double> spot = in_.spot;
      in_ = pen_of(e_, pen);
      in_.spot = spot;
      Move move;
      move.kind = Move::Kind::ask;
      move.asks = fmt::format("put in the pen of {}", name_of(pen));
      move.until = now.pen.time;
      return move;
    });
  }
  if (change) steps_.push_back(rest());
  if (checks_ && (change || first)) begin_check();
}

// Rest with the pen that is in, while a sensor is tared.
PenChanges::Step PenChanges::rest() const {
  return [this](const Situation& now) {
    Move move;
    move.kind = Move::Kind::wait;
    move.pen = in_;
    move.until = now.pen.time + e_.plan.path_settings.start_hold;
    return move;
  };
}

void PenChanges::begin_check() {
  const Eigen::Vector3d n = spot_->R.col(2), above = spot_->p + kAboveSpot * n;
  const Eigen::Vector3d over = above + axis_W_ * std::max(0.0, axis_W_.dot(place_W_ - above));
  steps_.push_back(go(over, n));
  steps_.push_back(go(above, n));
  steps_.push_back([](const Situation&) {
    Move move;
    move.kind = Move::Kind::feel;
    move.depth = kAboveSpot + kBeneath;
    return move;
  });
  steps_.push_back([this](const Situation& now) { return found(now); });
  steps_.push_back(go(over, n));
  steps_.push_back(go(place_W_, axis_W_));
}

// The way back up, with the pen's length as it was found; then the end, if it cannot be that.
Move PenChanges::found(const Situation& now) {
  const Eigen::Vector3d n = spot_->R.col(2);
  std::string wrong;
  if (!now.last.felt) {
    wrong = fmt::format("the pen of {} felt nothing on the spot of pen.check", name_of(in_.number));
  } else if (const double s = n.dot(*now.last.felt); in_.spot) {
    in_.longer += s - *in_.spot;
    remarks_.push_back(fmt::format("the tip of {} was found {:.2f} mm {} that of arm.urdf",
                                   name_of(in_.number), 1e3 * std::abs(in_.longer),
                                   in_.longer < 0.0 ? "short of" : "beyond"));
    if (!kPenLongerRange.holds(in_.longer)) wrong = remarks_.back() + ": is pen.spot right?";
  } else {
    in_.spot = s;
  }
  Move up = go(spot_->p + kAboveSpot * n, n)(now);
  if (wrong.empty()) {
    up.pen = in_;
    return up;
  }
  steps_.clear();
  steps_.push_back([wrong](const Situation&) {
    Move end;
    end.cause = wrong;
    return end;
  });
  return up;
}

PenChanges::Step PenChanges::go(const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W) const {
  return [this, p_W, n_W](const Situation& now) {
    const double turn = std::acos(std::clamp(-n_W.dot(now.pen.X_WE.R.col(2)), -1.0, 1.0));
    constexpr double kPeak = 1.875;  // of a minimum-jerk motion's speed, over its mean
    Move move;
    move.kind = Move::Kind::go_to;
    move.place_W = p_W;
    move.normal_W = n_W;
    move.until =
        now.pen.time +
        std::max({kLeast, kPeak * turn / kTurnRate,
                  kPeak * (p_W - now.pen.X_WE.p).norm() / e_.plan.path_settings.travel_speed});
    return move;
  };
}

// Straight up to the level of the place, with the pen as it is turned.
PenChanges::Step PenChanges::go_up() const {
  return [this](const Situation& now) {
    const Eigen::Vector3d& p = now.pen.X_WE.p;
    return go(p + axis_W_ * std::max(0.0, axis_W_.dot(place_W_ - p)), -now.pen.X_WE.R.col(2))(now);
  };
}

InkWatch PenChanges::ink_of(const Turn& turn, const InkWatch& ink) const {
  InkWatch seen = ink;
  for (const StrokePart& part : rest_of(e_.plan.strokes, turn.parts)) {
    seen.add(-1, 0.0, false);
    seen.add(part.stroke, part.from, true);
    seen.add(part.stroke, part.to, true);
  }
  return seen;
}

std::string PenChanges::name_of(int pen) const {
  for (const DrawnPen& drawn : e_.plan.pens->pens)
    if (drawn.number == pen) return fmt::format("layer '{}'", drawn.name);
  return "the drawing";
}

DrawingRecord PenChanges::record() const {
  DrawingRecord all;
  for (const Turn& turn : turns_) {
    const DrawingRecord one = turn.drawing->record();
    all.drawn_again.insert(all.drawn_again.end(), one.drawn_again.begin(), one.drawn_again.end());
    all.walls.insert(all.walls.end(), one.walls.begin(), one.walls.end());
  }
  all.remarks = remarks_;
  return all;
}

}  // namespace impedraw

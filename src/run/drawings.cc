#include "impedraw/run/drawings.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "impedraw/experiment/height_sources.h"

namespace impedraw {
namespace {

// It is one of the parts, or a piece of one.
bool is_among(const StrokePart& part, const std::vector<StrokePart>& parts) {
  return std::ranges::any_of(parts, [&](const StrokePart& p) {
    return p.stroke == part.stroke && p.from <= part.from && p.to >= part.to;
  });
}

}  // namespace

StandingDrawing::StandingDrawing(const Experiment& e, TipPath first, BlockedPlaces blocked)
    : e_(e), first_(std::move(first)), blocked_(std::move(blocked)) {}

StandingDrawing::StandingDrawing(const Experiment& e, std::vector<StrokePart> left)
    : e_(e), rises_(true), left_(std::move(left)) {}

Move StandingDrawing::next(const Situation& now) {
  const Pose X_KE = now.X_KE();
  if (std::exchange(rises_, false)) {
    Move rise;
    rise.kind = Move::Kind::lift;
    return rise;
  }
  if (!std::exchange(begun_, true)) {
    if (!left_.empty())
      first_ = checked_path(e_, &left_, X_KE.p, -X_KE.R.col(2), e_.plan.path_settings.start_hold,
                            now.pen.q, &blocked_);
    end_ = first_.at(first_.duration()).reference;
    return draw(std::move(first_));
  }
  if (now.last.blocked && !blocked_.full()) {
    const StrokePart& at = *now.last.blocked;
    blocked_.add(at);
    std::vector<StrokePart> parts = remaining(e_, now.ink, blocked_.parts());
    // Parts that were passed without ink are drawn again at the end, not after each blocked place.
    std::erase_if(parts, [&at](const StrokePart& p) {
      return p.stroke < at.stroke || (p.stroke == at.stroke && p.to <= at.to);
    });
    TipPath around = checked_path(e_, &parts, X_KE.p, -X_KE.R.col(2), 0.0, now.pen.q, &blocked_);
    if (!parts.empty()) return draw(std::move(around));
  }
  const bool once = e_.scenario.drawing.dry_run || !e_.scenario.drawing.redraw;
  if (once || std::exchange(again_, true)) return {};
  const bool at_end = blocked_.parts().empty();
  drawn_again_ = remaining(e_, now.ink, blocked_.parts());
  TipPath path =
      checked_path(e_, &drawn_again_, at_end ? end_.p_WD : X_KE.p,
                   at_end ? end_.n_WD : Eigen::Vector3d(-X_KE.R.col(2)), 0.0, now.pen.q, &blocked_);
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

MovingDrawing::MovingDrawing(const Experiment& e, double first_time)
    : e_(e), plan_(e, first_time), first_time_(first_time) {}

Move MovingDrawing::next(const Situation& now) {
  std::optional<Move> move;
  switch (stage_) {
    case Stage::begin:
      if (first_time_ > 0.0) {  // an earlier run may have left the pen on the canvas
        stage_ = Stage::raised;
        move.emplace().kind = Move::Kind::lift;
        return *move;
      }
      [[fallthrough]];
    case Stage::raised:
      if (first_time_ > 0.0 && left_by(now.ink).empty()) return {};
      stage_ = Stage::watched;
      move.emplace().kind = Move::Kind::wait;
      move->until = now.pen.time + e_.scenario.perception.watch;
      move->waits_for = "the cameras to watch the canvas";
      return *move;
    case Stage::risen:
      return wait(now);
    case Stage::watched:
      move = end_of_watch(now);
      break;
    case Stage::waited:
      move = end_of_wait(now);
      break;
    case Stage::drawn:
      move = end_of_path(now);
      break;
    case Stage::decide:
      break;
  }
  return move ? *move : decide(now);
}

std::optional<Move> MovingDrawing::end_of_watch(const Situation& now) {
  if (now.canvas == CanvasStatus::lost) {
    Move move;
    move.cause = fmt::format(
        "no camera saw three marks of the canvas within {:.3g} s; perception.fiducials.points and "
        "perception.cameras tell where they should be",
        e_.scenario.perception.watch);
    return move;
  }
  if (now.belief) record_.canvas_open = now.belief->open_text();
  begin_pass(left_by(now.ink));
  return std::nullopt;
}

std::optional<Move> MovingDrawing::end_of_wait(const Situation& now) {
  waited_ += now.pen.time - wait_began_;
  if (waited_ < kMostWait) return std::nullopt;
  pending_ = merged(pending_);
  return give_up(without_misses(e_, &pending_, [&](const std::vector<StrokePart>& parts) {
    std::vector<UnreachedPart> lost;
    for (const StrokePart& part : parts)
      lost.push_back({part, plan_.reason(part, forecast(now), now.pen) +
                                fmt::format("; no way to it was found in {:.0f} s", kMostWait)});
    return lost;
  }));
}

std::optional<Move> MovingDrawing::end_of_path(const Situation& now) {
  const PathEnd& last = now.last;
  const std::vector<StrokePart>& parts = decision_.parts;
  std::optional<Move> end;
  if (last.blocked) {
    blocked_.add(*last.blocked);
    if (blocked_.full()) {
      pending_.clear();
      return std::nullopt;
    }
  } else if (last.left_reach) {
    // The forecast did not say so.
    if (++left_reach_ == kMostLeft) {
      const StrokePart& part = parts[std::min(last.strokes_followed, parts.size() - 1)];
      end = give_up({{part, fmt::format("stroke {} left the arm's reach at t = {:.1f} s, {} times",
                                        plan_.number_of(part.stroke), first_time_ + now.pen.time,
                                        left_reach_)}});
      left_reach_ = 0;
    }
  } else if (last.lost_canvas) {
    ++losses_;
  } else {
    // A gap within what was followed is drawn later, with others.
    const auto begun = parts.begin();
    const std::vector<StrokePart> followed(
        begun, begun + static_cast<std::ptrdiff_t>(last.strokes_followed));
    std::erase_if(pending_, [&](const StrokePart& p) { return is_among(p, followed); });
    return std::nullopt;
  }
  pending_ = left_by(now.ink);
  return end;
}

Move MovingDrawing::decide(const Situation& now) {
  while (true) {
    if (pending_.empty() || losses_ > kMostLosses) {
      const bool once = e_.scenario.drawing.dry_run || !e_.scenario.drawing.redraw;
      if (std::exchange(again_, true) || once) return {};
      record_.drawn_again = left_by(now.ink);
      if (record_.drawn_again.empty()) return {};
      begin_pass(record_.drawn_again);
    }
    CarriedDecision decision = without_misses(
        e_, &pending_,
        [&](const std::vector<StrokePart>& left) { return decision_for(left, now); });
    for (const std::string& remark : decision.remarks) remark_on(remark);
    if (!decision.too_long.empty()) {
      cut(decision.too_long);
      continue;
    }
    if (std::optional<Move> end = give_up(decision.lost)) return *end;
    if (decision.kind == CarriedDecision::Kind::draw) return draw(std::move(decision));
    if (decision.kind == CarriedDecision::Kind::nothing) continue;
    std::stable_partition(pending_.begin(), pending_.end(),
                          [&](const StrokePart& p) { return !is_among(p, decision.in_vain); });
    decision_ = std::move(decision);
    wait_began_ = now.pen.time;
    if (!now.pen.joined) return wait(now);
    stage_ = Stage::risen;
    Move rise;
    rise.kind = Move::Kind::lift;
    return rise;
  }
}

Move MovingDrawing::draw(CarriedDecision decision) {
  stage_ = Stage::drawn;
  waited_ = 0.0;
  Move move;
  move.kind = Move::Kind::draw;
  move.path = std::move(decision.path);
  move.again = again_;
  move.join = decision.join;
  move.holds = [this](const Situation& now, const TipPath& path, double planned) {
    return !e_.scenario.preflight.arm || plan_.holds(path, planned, forecast(now), now.pen);
  };
  move.complete = [this](const InkWatch& ink) {
    std::vector<StrokePart> given_up;
    for (const UnreachedPart& u : record_.unreached) given_up.push_back(u.part);
    return remaining(e_, ink, given_up).empty();
  };
  decision_ = std::move(decision);
  return move;
}

Move MovingDrawing::wait(const Situation& now) {
  // Forecasts are made anew: the motion may change.
  constexpr double kShortest = 0.05, kLongest = 1.0;  // [s]
  stage_ = Stage::waited;
  Move move;
  move.kind = decision_.place_W ? Move::Kind::go_to : Move::Kind::wait;
  move.waits_for = "a stroke to come into reach";
  if (decision_.place_W) {
    move.place_W = *decision_.place_W;
    move.until = decision_.until;
  } else {
    move.until = std::clamp(decision_.until, now.pen.time + kShortest, now.pen.time + kLongest);
  }
  return move;
}

CarriedDecision MovingDrawing::decision_for(const std::vector<StrokePart>& parts,
                                            const Situation& now) {
  if (parts.empty()) return {};
  if (e_.scenario.preflight.arm) return plan_.decide(parts, forecast(now), now.pen);
  CarriedDecision all;
  all.kind = CarriedDecision::Kind::draw;
  all.join = now.pen.joined ? 0.0 : CanvasFollower::kJoin;
  const Pose here = now.X_KE();
  all.path = path_for(e_, parts, here.p, -here.R.col(2), all.join);
  all.parts = parts;
  return all;
}

CanvasForecast MovingDrawing::forecast(const Situation& now) const {
  return e_.scenario.perception.frames.wait_for_rest ? CanvasForecast::standing(now.pen.X_WK)
                                                     : now.history.forecast();
}

void MovingDrawing::begin_pass(std::vector<StrokePart> parts) {
  pending_ = std::move(parts);
  waited_ = 0.0;
  losses_ = 0;
}

std::vector<StrokePart> MovingDrawing::left_by(const InkWatch& ink) const {
  std::vector<StrokePart> given_up = blocked_.parts();
  for (const UnreachedPart& u : record_.unreached) given_up.push_back(u.part);
  return remaining(e_, ink, given_up);
}

void MovingDrawing::cut(const std::vector<StrokePart>& parts) {
  constexpr double kLongest = 2.0;  // [m]
  std::vector<StrokePart> all;
  for (const StrokePart& p : pending_) {
    const int n =
        !is_among(p, parts) ? 1 : std::max(2, static_cast<int>(std::ceil(p.length() / kLongest)));
    for (int i = 0; i < n; ++i)
      all.push_back({p.stroke, p.from + p.length() * i / n,
                     i + 1 == n ? p.to : p.from + p.length() * (i + 1) / n});
  }
  pending_ = std::move(all);
}

std::optional<Move> MovingDrawing::give_up(const std::vector<UnreachedPart>& lost) {
  for (const UnreachedPart& u : lost) {
    record_.unreached.push_back(u);
    std::erase_if(pending_, [&](const StrokePart& p) { return is_among(p, {u.part}); });
  }
  if (lost.empty() || e_.scenario.drawing.skip_unreachable) return std::nullopt;
  Move end;
  end.cause = lost.front().text +
              (lost.size() == 1 ? "" : fmt::format(", and {} more", lost.size() - 1)) +
              "; --skip-unreachable draws the rest";
  return end;
}

void MovingDrawing::remark_on(const std::string& remark) {
  std::vector<std::string>& remarks = record_.remarks;
  const auto about = [](const std::string& r) {  // without times that were forecast anew
    return r.substr(0, std::min(r.find(" from "), r.find(':')));
  };
  if (std::none_of(remarks.begin(), remarks.end(),
                   [&](const std::string& r) { return about(r) == about(remark); }))
    remarks.push_back(remark);
}

DrawingRecord MovingDrawing::record() const {
  DrawingRecord record = record_;
  record.walls = blocked_.parts();
  return record;
}

}  // namespace impedraw

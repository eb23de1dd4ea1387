#include "impedraw/run/carried_plan.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "impedraw/run/canvas_follower.h"
#include "impedraw/run/remaining.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kMostLooks = 2e5;   // places of all strokes at all times together
constexpr double kStepOfTime = 0.1;  // between starts that are tried, at least [s]
constexpr double kAbove = 0.02;      // the safe height: where a pen from its rest goes to [m]
constexpr double kLastOfJoin = 0.3;  // the pen is where it goes to within 6 % by then [s]
constexpr double kAlong = 0.5 * CanvasFollower::kShed;  // as the pen leaves the canvas [s]
constexpr double kWaitAbove = 0.15;  // a stroke's first point, where it will be [m]
constexpr double kWayStep = 0.02;    // between places on the way to where it waits [m]
constexpr double kLater = 1.0;       // the next decision, where several were tried in vain [s]
constexpr double kAgain = 0.25;      // the next decision, where a window's edge is not clear [s]

bool adjoin(const StrokePart& a, const StrokePart& b) {
  return a.stroke == b.stroke && a.to == b.from;
}

double join_of(const CarriedPen& pen) { return pen.joined ? 0.0 : CanvasFollower::kJoin; }

}  // namespace

CarriedPlan::CarriedPlan(const Experiment& experiment, double first_time)
    : e_(experiment),
      first_time_(first_time),
      checks_(preflight_settings(experiment.scenario, experiment.artwork.X_WP,
                                 experiment.belief.perception != nullptr, experiment.plan.rest_q)),
      reach_(experiment.belief.arm, experiment.belief.start_q, checks_) {}

int CarriedPlan::number_of(int stroke) const {
  const Plan& plan = e_.plan;
  return plan.source[static_cast<std::size_t>(
      plan.preflight.drawable[static_cast<std::size_t>(stroke)].stroke)];
}

TipPath CarriedPlan::plan(const std::vector<StrokePart>& parts, const Vector3d& p_K,
                          const Vector3d& n_K, double hold) const {
  return plan_from(e_.plan.path_settings, e_.surface(), strokes_of(e_, parts), p_K, n_K, hold,
                   stroke_limits(e_.belief, e_.plan, e_.plan.path_settings));
}

// From where the pen is.
TipPath CarriedPlan::from_here(const std::vector<StrokePart>& parts, const CarriedPen& pen) const {
  const Pose X_KE = pen.X_WK.inverse() * pen.X_WE;
  return plan(parts, X_KE.p, -X_KE.R.col(2), join_of(pen));
}

// The first fault of the path, if it is begun now.
std::optional<CarriedFault> CarriedPlan::fault(const TipPath& path, const CanvasForecast& forecast,
                                               const CarriedPen& pen, double join) const {
  CarriedPath carried{&path, pen.time, [&](double time) { return forecast.at(time); }, {}, kAlong};
  CanvasFollower follower([&](double time) {
    CanvasEstimate canvas;
    canvas.status = CanvasStatus::ok;
    canvas.motion.X_WK = forecast.at(time);
    return canvas;
  });
  if (!pen.joined) {
    follower.update(pen.time);
    TipReference rest;
    rest.p_WD = pen.X_WE.p;
    rest.n_WD = -pen.X_WE.R.col(2);
    follower.join(rest, join);
    carried.in_world = [&follower](const TipReference& in_K, double time) {
      follower.update(time);
      return follower.in_world(in_K);
    };
  }
  return check_carried(carried, e_.belief.arm, e_.belief.obstacle.get(), pen.q, checks_, 0.0,
                       kHorizon);
}

std::string CarriedPlan::fault_text(int stroke, const CarriedFault& fault) const {
  return fmt::format("stroke {} {} at t = {:.1f} s: {}", number_of(stroke), fault.what,
                     first_time_ + fault.time, fault.how);
}

std::string CarriedPlan::window_text(const ReachWindow& window) const {
  return fmt::format("is in reach from {:.1f} to {:.1f} s", first_time_ + window.from,
                     first_time_ + window.until);
}

bool CarriedPlan::holds(const TipPath& path, double planned, const CanvasForecast& forecast,
                        const CarriedPen& pen) {
  std::size_t next = 0;
  while (next < path.strokes().size() && path.strokes()[next].end < planned) ++next;
  if (next == path.strokes().size()) return true;
  const CarriedPath carried{
      &path, pen.time - planned, [&](double time) { return forecast.at(time); }, {}, kAlong};
  return !check_carried(carried, e_.belief.arm, e_.belief.obstacle.get(), pen.q, checks_, planned,
                        path.strokes()[next].approach);
}

// The time ahead of the parts that shall be drawn; one entry for each.
struct CarriedPlan::Outlook {
  const std::vector<StrokePart>& parts;
  const CanvasForecast& forecast;
  const CarriedPen& pen;
  const PathSettings& ways;
  Vector3d up;                       // z_P
  CarriedFault planned;              // why they are not drawn as planned
  std::vector<StrokeJob> jobs = {};  // and their windows
  std::vector<Vector3d> first = {};  // where their approaches begin, in K [m]
  double between = 0.0;              // from one's last point to the next one's approach [s]
  double end = 0.0;                  // of the last time that was looked at [s]

  // A pen at rest in W goes over to a place above the first point, and down from there.
  double height() const { return ways.safe_height + kAbove; }
  double down() const { return 2.0 * height() / ways.travel_speed; }
  Vector3d above(std::size_t job) const { return first[job] + height() * up; }
  double join_to(std::size_t job) const {
    const double way = (forecast.at(pen.time + 2.0) * above(job) - pen.X_WE.p).norm();
    return std::max(CanvasFollower::kJoin, 1.875 * way / ways.travel_speed);
  }
  // The earliest approach [s].
  double now() const {
    return pen.time + (pen.joined ? std::max(between, 0.5) : join_to(0) + down());
  }
};

void CarriedPlan::look_ahead(const TipPath& planned, Outlook* ahead) {
  const std::vector<StrokeTimes>& times = planned.strokes();
  double drawn = 0.0;  // by strokes that may fit [s]
  for (const StrokeTimes& s : times)
    if (s.end - s.approach < kHorizon) drawn += s.end - s.approach;
  CanvasPoses canvas{
      ahead->pen.time, std::max(kStepOfTime, std::sqrt(drawn * kHorizon / kMostLooks)), {}};
  for (double t = 0.0; t <= kHorizon; t += canvas.step)
    canvas.X_WK.push_back(ahead->forecast.at(canvas.begin + t));
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto& [number, approach, start, end, length] = times[i];
    const bool continues = i > 0 && adjoin(ahead->parts[i - 1], ahead->parts[i]);
    ahead->jobs.push_back({end - approach, reach_.windows(planned, i, canvas, kAlong),
                           start - approach, continues,
                           continues ? reach_.windows(planned, i, canvas, kAlong, true)
                                     : std::vector<ReachWindow>()});
    ahead->first.push_back(planned.at(approach).reference.p_WD);
    if (i > 0)
      ahead->between += (approach - times[i - 1].end) / static_cast<double>(times.size() - 1);
  }
  ahead->end = canvas.begin + kHorizon - 2.0 * canvas.step;
}

std::string CarriedPlan::reason(const StrokePart& part, const CanvasForecast& forecast,
                                const CarriedPen& pen) const {
  const std::optional<CarriedFault> why =
      fault(from_here({part}, pen), forecast, pen, join_of(pen));
  return why ? fault_text(part.stroke, *why)
             : fmt::format("stroke {} is out of the arm's reach once others are drawn",
                           number_of(part.stroke));
}

// Each of them with the reason that it cannot be drawn.
std::vector<UnreachedPart> CarriedPlan::named(const std::vector<std::size_t>& lost,
                                              const Outlook& ahead) const {
  std::vector<UnreachedPart> all;
  for (const std::size_t job : lost) {
    const StrokePart& part = ahead.parts[job];
    // Pieces that lie side by side are told as one.
    if (!all.empty() && adjoin(all.back().part, part)) {
      all.back().part.to = part.to;
      continue;
    }
    const int first = ahead.parts[ahead.planned.stroke].stroke;
    all.push_back({part, first == part.stroke ? fault_text(part.stroke, ahead.planned)
                                              : reason(part, ahead.forecast, ahead.pen)});
    if (const std::vector<ReachWindow>& windows = ahead.jobs[job].windows; !windows.empty())
      all.back().text += "; it " + window_text(windows.front());
  }
  return all;
}

// The place to wait for a part: nearer to it, if there is time, as the arm reaches further from
// there.
void CarriedPlan::wait_near(const StrokeSlot& slot, const Outlook& ahead,
                            CarriedDecision* out) const {
  const CarriedPen& pen = ahead.pen;
  const Vector3d place =
      ahead.forecast.at(slot.start) * ahead.first[slot.job] + kWaitAbove * ahead.up;
  const double move = 1.875 * (place - pen.X_WE.p).norm() / ahead.ways.travel_speed;
  if (pen.joined || move <= 1.0 ||
      slot.start <= pen.time + move + CanvasFollower::kJoin + ahead.down() + kSoon)
    return;
  PostureCheck check(e_.belief.arm, nullptr, pen.q, checks_);
  check.asked.torque = check.asked.pen = false;
  Posture last = standing_at(pen.q);
  const double way = (place - pen.X_WE.p).norm(), steps = std::ceil(way / kWayStep);
  for (double k = 1.0; k <= steps; ++k) {
    const Vector3d on_way = pen.X_WE.p + k / steps * (place - pen.X_WE.p);
    last = check.follow({on_way, pen.X_WE.R.col(2)}, last, way / steps);
    if (last.problem) return;
  }
  out->place_W = place;
  out->until = pen.time + move;
}

// Lays a path to the jobs: as many of them, from the first on, as it can be followed to and along.
// Returns false if none can.
bool CarriedPlan::lay(std::vector<std::size_t> jobs, const Outlook& ahead,
                      CarriedDecision* out) const {
  out->join = ahead.pen.joined ? 0.0 : ahead.join_to(jobs.front());
  while (!jobs.empty()) {
    out->parts.clear();
    std::vector<std::size_t> last;  // of each part: its last job
    for (std::size_t k = 0; k < jobs.size(); ++k) {
      const StrokePart& part = ahead.parts[jobs[k]];
      if (out->parts.empty() || !adjoin(out->parts.back(), part)) {
        out->parts.push_back(part);
        last.emplace_back();
      }
      out->parts.back().to = part.to;
      last.back() = k;
    }
    // From rest, down while the last of it goes over.
    out->path = ahead.pen.joined ? from_here(out->parts, ahead.pen)
                                 : plan(out->parts, ahead.above(jobs.front()), ahead.up,
                                        out->join - kLastOfJoin);
    const std::optional<CarriedFault> why = fault(out->path, ahead.forecast, ahead.pen, out->join);
    if (!why) return true;
    jobs.resize(last[why->stroke]);
  }
  out->parts.clear();
  return false;
}

CarriedDecision CarriedPlan::decide(const std::vector<StrokePart>& parts,
                                    const CanvasForecast& forecast, const CarriedPen& pen) {
  CarriedDecision out;
  if (parts.empty()) return out;
  out.kind = CarriedDecision::Kind::draw;
  out.parts = parts;
  out.join = join_of(pen);
  out.path = from_here(parts, pen);
  const std::optional<CarriedFault> planned = fault(out.path, forecast, pen, out.join);
  if (!planned) return out;
  Outlook ahead{parts, forecast, pen, e_.plan.path_settings, e_.artwork.X_WP.R.col(2), *planned};
  look_ahead(out.path, &ahead);
  const StrokeChoice choice =
      choose_strokes(ahead.jobs, ahead.now(), ahead.between, ahead.end, forecast.window() >= kSure);
  const std::vector<StrokeSlot>& slots = choice.order.slots;
  out = {};
  for (const std::size_t job : choice.lost)
    if (parts[job].length() > kShortest) out.too_long.push_back(parts[job]);
  if (!out.too_long.empty()) return out;
  out.lost = named(choice.lost, ahead);
  if (choice.lost.size() == parts.size()) return out;

  // A place may be in reach, and yet not from the posture in which the arm is: others come first.
  for (const std::vector<std::size_t>& jobs : choice.now) {
    if (lay(jobs, ahead, &out)) {
      out.kind = CarriedDecision::Kind::draw;
      if (out.parts.front().stroke != parts.front().stroke &&
          !std::ranges::count(choice.order.lost, std::size_t{0}))
        out.remarks.push_back(fmt::format("stroke {} is drawn first: as planned, {}",
                                          number_of(out.parts.front().stroke),
                                          fault_text(parts[planned->stroke].stroke, *planned)));
      return out;
    }
    out.in_vain.push_back(parts[jobs.front()]);
  }
  out.kind = CarriedDecision::Kind::wait;
  if (out.in_vain.empty()) {
    out.until = pen.time + 2.0 * kAgain;
    if (slots.empty()) return out;
    const StrokeSlot& first = slots.front();
    out.remarks.push_back(
        fmt::format("stroke {} {}", number_of(parts[first.job].stroke), window_text(first.window)));
    out.until = first.start - (ahead.join_to(first.job) + ahead.down());
    wait_near(first, ahead, &out);
  } else {
    out.until = pen.time + (out.in_vain.size() > 1 ? kLater : kAgain);
    if (out.in_vain.front().length() > kShortest) out.too_long.push_back(out.in_vain.front());
    if (const auto next = slot_of(ahead.jobs, slots.front().job, ahead.now() + 2.0 * kLater))
      wait_near(*next, ahead, &out);
  }
  return out;
}

}  // namespace impedraw

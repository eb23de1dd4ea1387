#include "impedraw/run/carried_plan.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/run/canvas_follower.h"
#include "impedraw/run/remaining.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr int kPlaces = 7;            // along a stroke, at most
constexpr double kMostLooks = 12000;  // postures of all windows together
constexpr double kStepOfTime = 0.1;   // between starts that are tried [s]
constexpr double kSoon = 0.3;         // a start that is that near is now [s]
constexpr double kAbove = 0.02;       // the safe height: where a pen from its rest goes to [m]
constexpr double kLastOfJoin = 0.3;   // the pen is where it goes to within 6 % by then [s]
constexpr double kWaitAbove = 0.15;   // a stroke's first point, where it will be [m]
constexpr std::size_t kOthers = 8;    // strokes that are tried where the first cannot be followed
constexpr double kLater = 1.0;        // the next decision, where several were tried in vain [s]
constexpr double kAgain = 0.25;       // the next decision, where a window's edge is not clear [s]

constexpr double kNever = std::numeric_limits<double>::infinity();

// The earliest slot of a job from `time` on.
std::optional<StrokeSlot> slot_of(const std::vector<StrokeJob>& jobs, std::size_t job,
                                  double time) {
  for (const ReachWindow& w : jobs[job].windows) {
    const double start = std::max(time, w.from);
    if (start + jobs[job].duration <= w.until + 1e-9) return StrokeSlot{job, start, w};
  }
  return std::nullopt;
}

// It can be drawn beyond the horizon, too: a window is open at its end, or opened twice before.
bool comes_again(const StrokeJob& job, double horizon) {
  return job.windows.size() > 1 || (!job.windows.empty() && job.windows.back().until >= horizon);
}

double end_of(const StrokeSchedule& s, const std::vector<StrokeJob>& jobs) {
  return s.slots.empty() ? 0.0 : s.slots.back().start + jobs[s.slots.back().job].duration;
}

StrokeSchedule as_planned(const std::vector<StrokeJob>& jobs, double now, double between) {
  StrokeSchedule s;
  double time = now;
  for (std::size_t job = 0; job < jobs.size(); ++job) {
    if (const auto slot = slot_of(jobs, job, time)) {
      s.slots.push_back(*slot);
      time = slot->start + jobs[job].duration + between;
    } else {
      s.lost.push_back(job);
    }
  }
  return s;
}

StrokeSchedule by_deadline(const std::vector<StrokeJob>& jobs, double now, double between) {
  StrokeSchedule s;
  std::vector<bool> open(jobs.size(), true);
  double time = now;
  while (true) {
    std::optional<StrokeSlot> best;
    double best_deadline = kNever;
    double earliest = kNever;  // start of any
    for (std::size_t job = 0; job < jobs.size(); ++job)
      if (open[job])
        if (const auto slot = slot_of(jobs, job, time)) earliest = std::min(earliest, slot->start);
    for (std::size_t job = 0; job < jobs.size(); ++job) {
      if (!open[job]) continue;
      const auto slot = slot_of(jobs, job, time);
      if (!slot || slot->start > earliest) continue;
      const double deadline = jobs[job].windows.back().until - jobs[job].duration;
      if (best && deadline >= best_deadline) continue;
      best = slot;
      best_deadline = deadline;
    }
    if (!best) break;
    open[best->job] = false;
    s.slots.push_back(*best);
    time = best->start + jobs[best->job].duration + between;
  }
  for (std::size_t job = 0; job < jobs.size(); ++job)
    if (open[job]) s.lost.push_back(job);
  return s;
}

}  // namespace

CarriedPlan::CarriedPlan(const Experiment& experiment, double first_time)
    : e_(experiment),
      first_time_(first_time),
      checks_(preflight_settings(experiment.scenario, experiment.artwork.X_WP,
                                 experiment.belief.perception != nullptr, experiment.plan.rest_q)) {
}

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

// The first fault of the path, if it is begun now.
std::optional<CarriedFault> CarriedPlan::fault(const TipPath& path, const CanvasForecast& forecast,
                                               const CarriedPen& pen, double join) const {
  CarriedPath carried{&path, pen.time, [&](double time) { return forecast.at(time); }, {}};
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

// Why a stroke cannot be drawn. fault: of the plan, if it is this stroke's.
std::string CarriedPlan::lost_text(const StrokePart& part, std::optional<CarriedFault> fault_of_it,
                                   const StrokeJob& job, const CanvasForecast& forecast,
                                   const CarriedPen& pen) const {
  if (!fault_of_it) {
    const Pose X_KE = pen.X_WK.inverse() * pen.X_WE;
    const double join = pen.joined ? 0.0 : CanvasFollower::kJoin;
    fault_of_it = fault(plan({part}, X_KE.p, -X_KE.R.col(2), join), forecast, pen, join);
  }
  std::string text = fault_of_it
                         ? fault_text(part.stroke, *fault_of_it)
                         : fmt::format("stroke {} is out of the arm's reach once others are drawn",
                                       number_of(part.stroke));
  if (!job.windows.empty())
    text += fmt::format("; it is in reach from {:.1f} to {:.1f} s",
                        first_time_ + job.windows.front().from,
                        first_time_ + job.windows.front().until);
  return text;
}

bool CarriedPlan::holds(const TipPath& path, double planned, const CanvasForecast& forecast,
                        const CarriedPen& pen) {
  std::size_t next = 0;
  while (next < path.strokes().size() && path.strokes()[next].end < planned) ++next;
  if (next == path.strokes().size()) return true;
  const CarriedPath carried{
      &path, pen.time - planned, [&](double time) { return forecast.at(time); }, {}};
  return !check_carried(carried, e_.belief.arm, e_.belief.obstacle.get(), pen.q, checks_, planned,
                        path.strokes()[next].approach);
}

CarriedDecision CarriedPlan::decide(const std::vector<StrokePart>& parts,
                                    const CanvasForecast& forecast, const CarriedPen& pen) {
  CarriedDecision out;
  if (parts.empty()) return out;
  const Pose X_KE = pen.X_WK.inverse() * pen.X_WE;
  out.join = pen.joined ? 0.0 : CanvasFollower::kJoin;
  out.path = plan(parts, X_KE.p, -X_KE.R.col(2), out.join);
  out.kind = CarriedDecision::Kind::draw;
  out.parts = parts;
  const std::optional<CarriedFault> planned = fault(out.path, forecast, pen, out.join);
  if (!planned) return out;

  // The windows in which each stroke is in reach.
  const std::vector<StrokeTimes> times = out.path.strokes();
  const double count = static_cast<double>(times.size());
  const int places =
      std::clamp(static_cast<int>(kMostLooks * kStepOfTime / (kHorizon * count)), 3, kPlaces);
  const double step = std::max(kStepOfTime, count * places * kHorizon / kMostLooks);
  const CanvasCourse course = [&](double time) { return forecast.at(time); };
  std::vector<StrokeJob> jobs;
  std::vector<TipReference> hover;
  double between = 0.0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const StrokePlaces of = places_of(out.path, i, places);
    jobs.push_back({of.duration, reach_windows(of, course, e_.belief.arm, pen.q, checks_, pen.time,
                                               pen.time + kHorizon, step)});
    hover.push_back(out.path.at(times[i].approach).reference);
    if (i > 0) between += (times[i].approach - times[i - 1].end) / (count - 1.0);
  }

  // A pen at rest in W goes over to a place above the first point.
  const Vector3d up = e_.artwork.X_WP.R.col(2);
  const double height = e_.plan.path_settings.safe_height + kAbove;
  const auto start_of = [&](std::size_t job) { return Vector3d(hover[job].p_WD + height * up); };
  const auto join_to = [&](std::size_t job) {
    const double way = (forecast.at(pen.time + 2.0) * start_of(job) - pen.X_WE.p).norm();
    return std::max(CanvasFollower::kJoin, 1.875 * way / e_.plan.path_settings.travel_speed);
  };
  const double down = 2.0 * height / e_.plan.path_settings.travel_speed;
  const double lead = pen.joined ? std::max(between, 0.5) : join_to(0) + down;
  const StrokeSchedule order = schedule_strokes(jobs, pen.time + lead, between);

  out.kind = CarriedDecision::Kind::nothing;
  out.path = {};
  out.parts.clear();
  const bool sure = forecast.window() >= kSure;
  const auto is_lost = [&](std::size_t job) {
    return sure && !comes_again(jobs[job], pen.time + kHorizon - step);
  };
  for (const std::size_t job : order.lost)
    if (is_lost(job) && parts[job].length() > kShortest) out.too_long.push_back(parts[job]);
  if (!out.too_long.empty()) return out;
  for (const std::size_t job : order.lost) {
    if (!is_lost(job)) continue;
    // Pieces that lie side by side are told as one.
    if (!out.lost.empty() && out.lost.back().part.stroke == parts[job].stroke &&
        out.lost.back().part.to == parts[job].from)
      out.lost.back().part.to = parts[job].to;
    else
      out.lost.push_back(
          {parts[job], lost_text(parts[job], planned->stroke == job ? planned : std::nullopt,
                                 jobs[job], forecast, pen)});
  }
  if (order.slots.empty()) {
    if (std::ranges::all_of(order.lost, is_lost)) return out;
    out.kind = CarriedDecision::Kind::wait;
    out.until = pen.time + 2.0 * kAgain;
    out.why = fault_text(parts[planned->stroke].stroke, *planned);
    return out;
  }

  const StrokeSlot& first = order.slots.front();
  if (first.start > pen.time + lead + kSoon) {
    out.kind = CarriedDecision::Kind::wait;
    out.until = first.start - (join_to(first.job) + down);
    // Nearer, if there is time.
    const Vector3d place = forecast.at(first.start) * hover[first.job].p_WD + kWaitAbove * up;
    ArmModel arm = e_.belief.arm;
    const double move = 1.875 * (place - pen.X_WE.p).norm() / e_.plan.path_settings.travel_speed;
    if (!pen.joined && move > 1.0 &&
        first.start > pen.time + move + CanvasFollower::kJoin + down + kSoon &&
        find_posture(arm, {place, pen.X_WE.R.col(2)}, pen.q).reached) {
      out.place_W = place;
      out.until = pen.time + move;
    }
    out.remarks.push_back(fmt::format(
        "stroke {} is in reach from {:.1f} to {:.1f} s", number_of(parts[first.job].stroke),
        first_time_ + first.window.from, first_time_ + first.window.until));
    out.why = fault_text(parts[planned->stroke].stroke, *planned);
    return out;
  }

  // As many of the parts, from the first on, as a path to them and along them can be followed.
  const auto lay = [&](std::size_t first_job) {
    while (!out.parts.empty()) {
      if (pen.joined) {
        out.path = plan(out.parts, X_KE.p, -X_KE.R.col(2), 0.0);
      } else {
        out.join = join_to(first_job);
        // Down while the last of it goes over.
        out.path = plan(out.parts, start_of(first_job), up, out.join - kLastOfJoin);
      }
      const std::optional<CarriedFault> why = fault(out.path, forecast, pen, out.join);
      if (!why) return true;
      if (out.why.empty()) out.why = fault_text(out.parts[why->stroke].stroke, *why);
      out.parts.resize(why->stroke);
    }
    return false;
  };
  double end = first.start;
  for (const StrokeSlot& slot : order.slots) {
    if (slot.start > end + between + kSoon) break;
    out.parts.push_back(parts[slot.job]);
    end = slot.start + jobs[slot.job].duration;
  }
  bool laid = lay(first.job);
  if (!laid) out.in_vain = {parts[first.job]};
  // A place may be in reach, and yet not from the posture in which the arm is: others come first.
  for (std::size_t k = 1; !laid && k < std::min(order.slots.size(), kOthers); ++k) {
    const std::size_t job = order.slots[k].job;
    const auto soon = slot_of(jobs, job, pen.time + lead);
    if (!soon || soon->start > pen.time + lead + kSoon) continue;
    out.parts = {parts[job]};
    laid = lay(job);
    if (!laid) out.in_vain.push_back(parts[job]);
  }
  if (!laid) {
    if (parts[first.job].length() > kShortest) out.too_long.push_back(parts[first.job]);
    out.kind = CarriedDecision::Kind::wait;
    out.until = pen.time + (out.in_vain.size() > 1 ? kLater : kAgain);
    return out;
  }
  out.kind = CarriedDecision::Kind::draw;
  const bool reordered =
      out.parts.front().stroke != parts.front().stroke &&
      std::none_of(order.lost.begin(), order.lost.end(), [](std::size_t job) { return job == 0; });
  if (reordered)
    out.remarks.push_back(fmt::format("stroke {} is drawn first: as planned, {}",
                                      number_of(out.parts.front().stroke),
                                      fault_text(parts[planned->stroke].stroke, *planned)));
  return out;
}

StrokeSchedule schedule_strokes(const std::vector<StrokeJob>& jobs, double now, double between) {
  StrokeSchedule planned = as_planned(jobs, now, between),
                 hurried = by_deadline(jobs, now, between);
  const bool fewer = hurried.lost.size() < planned.lost.size();
  const bool sooner = hurried.lost.size() == planned.lost.size() &&
                      end_of(hurried, jobs) < end_of(planned, jobs) - kWorth;
  return fewer || sooner ? hurried : planned;
}

}  // namespace impedraw

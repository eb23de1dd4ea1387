#include "impedraw/run/stroke_schedule.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace impedraw {

namespace {

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

StrokeSchedule schedule_strokes(const std::vector<StrokeJob>& jobs, double now, double between) {
  StrokeSchedule planned = as_planned(jobs, now, between),
                 hurried = by_deadline(jobs, now, between);
  const bool fewer = hurried.lost.size() < planned.lost.size();
  const bool sooner = hurried.lost.size() == planned.lost.size() &&
                      end_of(hurried, jobs) < end_of(planned, jobs) - kWorth;
  return fewer || sooner ? hurried : planned;
}

}  // namespace impedraw

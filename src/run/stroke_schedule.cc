#include "impedraw/run/stroke_schedule.h"

#include <algorithm>
#include <utility>

namespace impedraw {

std::optional<StrokeSlot> slot_of(const std::vector<StrokeJob>& jobs, std::size_t job,
                                  double time) {
  for (const ReachWindow& w : jobs[job].windows) {
    const double start = std::max(time, w.from);
    if (start + jobs[job].duration <= w.until + 1e-9) return StrokeSlot{job, start, w};
  }
  return std::nullopt;
}

namespace {

// The slot of the job that continues that slot's, if it can be drawn without a lift.
std::optional<StrokeSlot> continued(const std::vector<StrokeJob>& jobs, const StrokeSlot& slot) {
  const std::size_t next = slot.job + 1;
  if (next >= jobs.size() || !jobs[next].continues) return std::nullopt;
  const double begin = slot.start + jobs[slot.job].duration, start = begin - jobs[next].approach;
  for (const ReachWindow& w : jobs[next].behind)
    if (begin >= w.from && start + jobs[next].duration <= w.until + 1e-9)
      return StrokeSlot{next, start, w};
  const std::optional<StrokeSlot> at = slot_of(jobs, next, start);
  return at && at->start == start ? at : std::nullopt;
}

// One of the two orders.
StrokeSchedule schedule_in_order(const std::vector<StrokeJob>& jobs, double now, double between,
                                 bool by_deadline) {
  StrokeSchedule s;
  std::vector<bool> open(jobs.size(), true);
  const auto urgency = [&](const StrokeSlot& slot) {
    return std::pair(slot.start, jobs[slot.job].windows.back().until - jobs[slot.job].duration);
  };
  for (double time = now;;) {
    std::optional<StrokeSlot> best;
    for (std::size_t job = 0; job < jobs.size() && (by_deadline || !best); ++job) {
      if (!open[job]) continue;
      const std::optional<StrokeSlot> slot = slot_of(jobs, job, time);
      if (slot && (!best || urgency(*slot) < urgency(*best))) best = slot;
    }
    if (!best) break;
    do {
      open[best->job] = false;
      s.slots.push_back(*best);
      s.end = best->start + jobs[best->job].duration;
      best = continued(jobs, *best);
    } while (best && open[best->job]);
    time = s.end + between;
  }
  for (std::size_t job = 0; job < jobs.size(); ++job)
    if (open[job]) s.lost.push_back(job);
  return s;
}

}  // namespace

StrokeSchedule schedule_strokes(const std::vector<StrokeJob>& jobs, double now, double between) {
  StrokeSchedule planned = schedule_in_order(jobs, now, between, false),
                 hurried = schedule_in_order(jobs, now, between, true);
  const bool better = std::pair(hurried.lost.size(), hurried.end + kWorth) <
                      std::pair(planned.lost.size(), planned.end);
  return better ? hurried : planned;
}

StrokeChoice choose_strokes(const std::vector<StrokeJob>& jobs, double now, double between,
                            double horizon, bool sure) {
  StrokeChoice choice{schedule_strokes(jobs, now, between), {}, {}};
  for (const std::size_t job : choice.order.lost) {
    const std::vector<ReachWindow>& w = jobs[job].windows;
    const bool again = w.size() > 1 || (!w.empty() && w.back().until >= horizon) ||
                       (jobs[job].continues && !jobs[job].behind.empty());
    if (sure && !again) choice.lost.push_back(job);
  }
  const std::vector<StrokeSlot>& slots = choice.order.slots;
  if (slots.empty() || slots.front().start > now + kSoon) return choice;
  choice.now.emplace_back();
  for (double end = slots.front().start; const StrokeSlot& slot : slots) {
    if (slot.start > end + between + kSoon) break;
    choice.now.front().push_back(slot.job);
    end = slot.start + jobs[slot.job].duration;
  }
  for (std::size_t k = 1; k < std::min(slots.size(), kMostChoices); ++k) {
    const std::optional<StrokeSlot> soon = slot_of(jobs, slots[k].job, now);
    if (!soon || soon->start > now + kSoon) continue;
    choice.now.emplace_back();
    for (auto slot = soon; slot; slot = continued(jobs, *slot))
      choice.now.back().push_back(slot->job);
  }
  return choice;
}

}  // namespace impedraw

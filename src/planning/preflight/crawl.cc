#include "impedraw/planning/preflight/crawl.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace impedraw {

namespace {

constexpr double kSampled = 5e-3;   // between samples of the path [s]
constexpr double kShortest = 2e-3;  // shorter strokes are not judged [m]

// One stroke of a path, sample by sample.
struct Trace {
  std::vector<double> time, along, length;  // length: on the surface, from the first point [m]
};

Trace trace(const TipPath& path, const StrokeTimes& stroke) {
  Trace trace;
  double length = 0.0, along = 0.0;
  const int steps =
      std::max(1, static_cast<int>(std::ceil((stroke.end - stroke.start) / kSampled)));
  for (int k = 0; k <= steps; ++k) {
    const double t = stroke.start + (stroke.end - stroke.start) * k / steps;
    const PathSample sample = path.at(t);
    if (k > 0) length += sample.reference.v_WD.norm() * (t - trace.time.back());
    if (std::isfinite(sample.along)) along = std::max(along, sample.along);
    trace.time.push_back(t);
    trace.along.push_back(along);
    trace.length.push_back(length);
  }
  return trace;
}

// Time at `along`, between the samples before `after` and at it.
double time_between(const Trace& trace, std::vector<double>::const_iterator after, double along) {
  if (after == trace.along.begin()) return trace.time.front();
  if (after == trace.along.end()) return trace.time.back();
  const auto i = static_cast<std::size_t>(after - trace.along.begin());
  const double share = (along - trace.along[i - 1]) / (trace.along[i] - trace.along[i - 1]);
  return trace.time[i - 1] + share * (trace.time[i] - trace.time[i - 1]);
}

// Times at which the trace comes to `along`, and goes on from there: a led tool turns at corners.
double time_at(const Trace& trace, double along) {
  return time_between(trace, std::ranges::lower_bound(trace.along, along), along);
}
double time_past(const Trace& trace, double along) {
  return time_between(trace, std::ranges::upper_bound(trace.along, along), along);
}

struct Window {
  std::size_t begin, end;  // samples
};

// Slow windows that begin at each sample.
template <class Take>
void for_slow_windows(const Trace& t, double least_speed, Take&& take) {
  const std::size_t n = t.time.size();
  if (t.length.back() < kShortest) return;
  std::size_t end = 0;
  for (std::size_t begin = 0; begin + 1 < n; ++begin) {
    while (end + 1 < n && t.length[end] - t.length[begin] < kCrawlWindow) ++end;
    const double length = t.length[end] - t.length[begin];
    if (begin > 0 && length < kCrawlWindow) return;
    if (length < least_speed * (t.time[end] - t.time[begin])) take(Window{begin, end});
  }
}

bool is_slow_at(const Trace& t, std::size_t i, double least_speed) {
  std::size_t a = i, b = i;
  while (t.length[b] - t.length[a] < kCrawlStep && (a > 0 || b + 1 < t.time.size())) {
    if (a > 0) --a;
    if (b + 1 < t.time.size()) ++b;
  }
  return t.length[b] - t.length[a] < least_speed * (t.time[b] - t.time[a]);
}

}  // namespace

std::vector<std::size_t> slow_strokes(const TipPath& path, double least_speed) {
  std::vector<std::size_t> found;
  for (std::size_t s = 0; s < path.strokes().size(); ++s) {
    bool slow = false;
    for_slow_windows(trace(path, path.strokes()[s]), least_speed,
                     [&slow](const Window&) { slow = true; });
    if (slow) found.push_back(s);
  }
  return found;
}

std::vector<CrawlingStretch> crawling_stretches(const TipPath& path, const TipPath& unhindered,
                                                const std::vector<std::size_t>& strokes,
                                                double least_speed, double slowed) {
  std::vector<CrawlingStretch> found;
  for (std::size_t k = 0; k < strokes.size(); ++k) {
    const std::size_t s = strokes[k];
    const Trace slow = trace(path, path.strokes()[s]);
    std::vector<Window> merged;
    std::optional<Trace> free;
    for_slow_windows(slow, least_speed, [&](const Window& w) {
      if (!free) free = trace(unhindered, unhindered.strokes()[k]);
      const double fastest =
          time_past(*free, slow.along[w.end]) - time_at(*free, slow.along[w.begin]);
      if (slow.time[w.end] - slow.time[w.begin] < slowed * fastest) return;
      if (!merged.empty() && w.begin <= merged.back().end)
        merged.back().end = std::max(merged.back().end, w.end);
      else
        merged.push_back(w);
    });
    for (const Window& whole : merged) {
      Window w = whole;
      while (w.begin + 1 < w.end && !is_slow_at(slow, w.begin, least_speed)) ++w.begin;
      while (w.begin + 1 < w.end && !is_slow_at(slow, w.end, least_speed)) --w.end;
      while (slow.along[w.end] - slow.along[w.begin] < kCrawlStep &&
             (w.begin > whole.begin || w.end < whole.end)) {
        if (w.begin > whole.begin) --w.begin;
        if (w.end < whole.end) ++w.end;
      }
      CrawlingStretch c;
      c.stroke = s;
      c.from = slow.along[w.begin];
      c.to = slow.along[w.end];
      c.speed =
          (slow.length[w.end] - slow.length[w.begin]) / (slow.time[w.end] - slow.time[w.begin]);
      double longest = -1.0;
      for (std::size_t i = w.begin; i < w.end; ++i) {
        const double slowness =
            (slow.time[i + 1] - slow.time[i]) / std::max(slow.length[i + 1] - slow.length[i], 1e-9);
        if (slowness <= longest) continue;
        longest = slowness;
        c.slowest = slow.along[i];
        c.p_W = path.at(slow.time[i]).reference.p_WD;
      }
      found.push_back(c);
    }
  }
  return found;
}

}  // namespace impedraw

#include "impedraw/planning/path/speed_profile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <span>

namespace impedraw {
namespace {

// From `speed`, at constant acceleration up to `peak`, on at this speed, and down to the next.
struct Pass {
  double speed, peak;
  double up, cruise, down;  // durations [s]

  double duration() const { return up + cruise + down; }
};

Pass pass_of(const SpeedSpan& span, double v0, double v1) {
  const auto& [length, speed, a] = span;
  const double peak = std::min(speed, std::sqrt(a * length + (v0 * v0 + v1 * v1) / 2));
  const double up = std::max(0.0, peak - v0) / a, down = std::max(0.0, peak - v1) / a;
  const double cruise = std::max(0.0, length - up * (v0 + peak) / 2 - down * (v1 + peak) / 2);
  return {v0, peak, up, cruise / peak, down};
}

// The fastest passes over the spans, from rest to rest.
std::vector<Pass> fastest_passes(const std::vector<SpeedSpan>& spans) {
  const std::size_t n = spans.size();
  std::vector<double> at(n + 1, 0.0);  // speed at the joints
  for (std::size_t i = 1; i < n; ++i) {
    const SpeedSpan& s = spans[i - 1];
    at[i] = std::min({s.speed, spans[i].speed,
                      std::sqrt(at[i - 1] * at[i - 1] + 2 * s.acceleration * s.length)});
  }
  for (std::size_t i = n; i-- > 0;)
    at[i] = std::min(
        at[i], std::sqrt(at[i + 1] * at[i + 1] + 2 * spans[i].acceleration * spans[i].length));
  std::vector<Pass> passes;
  passes.reserve(n);
  for (std::size_t i = 0; i < n; ++i) passes.push_back(pass_of(spans[i], at[i], at[i + 1]));
  return passes;
}

// Replaces each span's limits by the lowest limits that the fastest passes meet within `time` of
// it, before or after. Slower passes meet no others.
void take_lowest_within(double time, const std::vector<Pass>& passes,
                        std::vector<SpeedSpan>* spans) {
  const std::size_t n = spans->size();
  std::vector<double> end(n);
  double t = 0;
  for (std::size_t i = 0; i < n; ++i) end[i] = t += passes[i].duration();
  const auto start = [&](std::size_t i) { return i == 0 ? 0.0 : end[i - 1]; };
  const auto lowest = [&](auto limit) {
    std::vector<double> result(n);
    std::deque<std::size_t> candidates;  // limits rise from front to back
    std::size_t next = 0;
    for (std::size_t i = 0; i < n; ++i) {
      for (; next < n && (next <= i || start(next) < end[i] + time); ++next) {
        while (!candidates.empty() && limit((*spans)[candidates.back()]) >= limit((*spans)[next]))
          candidates.pop_back();
        candidates.push_back(next);
      }
      while (end[candidates.front()] < start(i) - time) candidates.pop_front();
      result[i] = limit((*spans)[candidates.front()]);
    }
    return result;
  };
  const std::vector<double> speed = lowest([](const SpeedSpan& s) { return s.speed; });
  const std::vector<double> acceleration =
      lowest([](const SpeedSpan& s) { return s.acceleration; });
  for (std::size_t i = 0; i < n; ++i)
    (*spans)[i].speed = speed[i], (*spans)[i].acceleration = acceleration[i];
}

// Appends the pieces of a pass to any list of pieces.
template <class Pieces>
void append(const Pass& pass, double acceleration, Pieces* pieces, SpeedTotals* totals) {
  const auto add = [&](double duration, double speed, double a) {
    if (!(duration > 0)) return;
    if (pieces->empty() || a != 0 || pieces->back().acceleration != 0 ||
        std::abs(pieces->back().speed - speed) > 1e-12 * speed) {
      pieces->push_back({totals->end, totals->length, speed, a, totals->area});
    }
    totals->end += duration;
    const SpeedPiece& p = pieces->back();
    const double t = totals->end - p.start;
    totals->length = p.x + t * (p.speed + t * p.acceleration / 2);
    totals->area = p.area + t * (p.x + t * (p.speed / 2 + t * p.acceleration / 6));
  };
  add(pass.up, pass.speed, acceleration);
  add(pass.cruise, pass.peak, 0);
  add(pass.down, pass.peak, -acceleration);
}

struct Raw {
  double area, x, speed, acceleration;
};
Raw raw(std::span<const SpeedPiece> pieces, const SpeedTotals& totals, double t) noexcept {
  if (t <= 0) return {0, 0, 0, 0};
  if (t >= totals.end) return {totals.area + totals.length * (t - totals.end), totals.length, 0, 0};
  const auto after =
      std::upper_bound(pieces.begin(), pieces.end(), t,
                       [](double time, const SpeedPiece& p) { return time < p.start; });
  const SpeedPiece& p = *std::prev(after);
  const double s = t - p.start;
  return {p.area + s * (p.x + s * (p.speed / 2 + s * p.acceleration / 6)),
          p.x + s * (p.speed + s * p.acceleration / 2), p.speed + s * p.acceleration,
          p.acceleration};
}

SpeedState smoothed(std::span<const SpeedPiece> pieces, const SpeedTotals& totals, double T,
                    double t) noexcept {
  if (pieces.empty() || t <= 0) return {};
  if (t >= totals.end + T) return {totals.length, 0, 0};
  const Raw now = raw(pieces, totals, t);
  if (!(T > 0)) return {now.x, now.speed, now.acceleration};
  const Raw before = raw(pieces, totals, t - T);
  return {(now.area - before.area) / T, (now.x - before.x) / T, (now.speed - before.speed) / T};
}

// The pieces of one span, without a heap.
struct OneSpan {
  explicit OneSpan(const SpeedSpan& span) noexcept {
    if (span.length > 0) append(pass_of(span, 0.0, 0.0), span.acceleration, this, &totals);
  }
  bool empty() const { return size == 0; }
  const SpeedPiece& back() const { return pieces[size - 1]; }
  void push_back(const SpeedPiece& piece) { pieces[size++] = piece; }

  std::array<SpeedPiece, 3> pieces;
  std::size_t size = 0;
  SpeedTotals totals;
};

}  // namespace

SpeedProfile::SpeedProfile(std::vector<SpeedSpan> spans, double smoothing_time)
    : smoothing_(smoothing_time) {
  std::erase_if(spans, [](const SpeedSpan& s) { return !(s.length > 0); });
  if (spans.empty()) return;
  std::vector<Pass> passes = fastest_passes(spans);
  if (smoothing_ > 0) {
    take_lowest_within(smoothing_, passes, &spans);
    passes = fastest_passes(spans);
  }
  for (std::size_t i = 0; i < spans.size(); ++i)
    append(passes[i], spans[i].acceleration, &pieces_, &totals_);
  pieces_.shrink_to_fit();  // a drawing has many profiles
}

SpeedState SpeedProfile::at(double t) const noexcept {
  return smoothed(pieces_, totals_, smoothing_, t);
}

double rest_to_rest_duration(const SpeedSpan& span, double smoothing_time) noexcept {
  return span.length > 0 ? OneSpan(span).totals.end + smoothing_time : 0.0;
}

SpeedState rest_to_rest(const SpeedSpan& span, double smoothing_time, double t) noexcept {
  const OneSpan one(span);
  return smoothed({one.pieces.data(), one.size}, one.totals, smoothing_time, t);
}

}  // namespace impedraw

#include "impedraw/planning/path/speed_profile.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <deque>

namespace impedraw {
namespace {

// From `speed`, at constant acceleration up to `peak`, on at this speed, and down to the next.
struct Pass {
  double speed, peak;
  double up, cruise, down;  // durations [s]

  double duration() const { return up + cruise + down; }
};

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
  for (std::size_t i = 0; i < n; ++i) {
    const auto& [length, speed, a] = spans[i];
    const double v0 = at[i], v1 = at[i + 1];
    const double peak = std::min(speed, std::sqrt(a * length + (v0 * v0 + v1 * v1) / 2));
    const double up = std::max(0.0, peak - v0) / a, down = std::max(0.0, peak - v1) / a;
    const double cruise = std::max(0.0, length - up * (v0 + peak) / 2 - down * (v1 + peak) / 2);
    passes.push_back({v0, peak, up, cruise / peak, down});
  }
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
  for (std::size_t i = 0; i < spans.size(); ++i) {
    const Pass& pass = passes[i];
    add(pass.up, pass.speed, spans[i].acceleration);
    add(pass.cruise, pass.peak, 0);
    add(pass.down, pass.peak, -spans[i].acceleration);
  }
  pieces_.shrink_to_fit();  // a drawing has many profiles
}

void SpeedProfile::add(double duration, double speed, double acceleration) {
  if (!(duration > 0)) return;
  if (pieces_.empty() || acceleration != 0 || pieces_.back().acceleration != 0 ||
      std::abs(pieces_.back().speed - speed) > 1e-12 * speed) {
    pieces_.push_back({end_, length_, speed, acceleration, area_});
  }
  end_ += duration;
  const Piece& p = pieces_.back();
  const double t = end_ - p.start;
  length_ = p.x + t * (p.speed + t * p.acceleration / 2);
  area_ = p.area + t * (p.x + t * (p.speed / 2 + t * p.acceleration / 6));
}

SpeedProfile::Raw SpeedProfile::raw(double t) const noexcept {
  if (t <= 0) return {0, 0, 0, 0};
  if (t >= end_) return {area_ + length_ * (t - end_), length_, 0, 0};
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), t,
                                      [](double time, const Piece& p) { return time < p.start; });
  const Piece& p = *std::prev(after);
  const double s = t - p.start;
  return {p.area + s * (p.x + s * (p.speed / 2 + s * p.acceleration / 6)),
          p.x + s * (p.speed + s * p.acceleration / 2), p.speed + s * p.acceleration,
          p.acceleration};
}

SpeedState SpeedProfile::at(double t) const noexcept {
  if (pieces_.empty() || t <= 0) return {};
  if (t >= duration()) return {length_, 0, 0};
  const Raw now = raw(t);
  if (!(smoothing_ > 0)) return {now.x, now.speed, now.acceleration};
  const Raw before = raw(t - smoothing_);
  return {(now.area - before.area) / smoothing_, (now.x - before.x) / smoothing_,
          (now.speed - before.speed) / smoothing_};
}

}  // namespace impedraw

#include "impedraw/planning/path/speed_profile.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <deque>

namespace impedraw {
namespace {

// Replaces each span's limits by the lowest limits within `reach` of it.
void take_lowest_near(std::vector<SpeedSpan>& spans, double reach) {
  std::vector<double> end(spans.size());
  double x = 0;
  for (std::size_t i = 0; i < spans.size(); ++i) end[i] = x += spans[i].length;
  const auto start = [&](std::size_t i) { return i == 0 ? 0.0 : end[i - 1]; };
  const auto lowest = [&](auto limit) {
    std::vector<double> result(spans.size());
    std::deque<std::size_t> candidates;  // limits rise from front to back
    std::size_t next = 0;
    for (std::size_t i = 0; i < spans.size(); ++i) {
      for (; next < spans.size() && (next <= i || start(next) < end[i] + reach); ++next) {
        while (!candidates.empty() && limit(spans[candidates.back()]) >= limit(spans[next]))
          candidates.pop_back();
        candidates.push_back(next);
      }
      while (end[candidates.front()] < start(i) - reach) candidates.pop_front();
      result[i] = limit(spans[candidates.front()]);
    }
    return result;
  };
  const std::vector<double> speed = lowest([](const SpeedSpan& s) { return s.speed; });
  const std::vector<double> acceleration =
      lowest([](const SpeedSpan& s) { return s.acceleration; });
  for (std::size_t i = 0; i < spans.size(); ++i)
    spans[i].speed = speed[i], spans[i].acceleration = acceleration[i];
}

}  // namespace

SpeedProfile::SpeedProfile(std::vector<SpeedSpan> spans, double smoothing_time)
    : smoothing_(smoothing_time) {
  std::erase_if(spans, [](const SpeedSpan& s) { return !(s.length > 0); });
  if (spans.empty()) return;
  double fastest = 0;
  for (const SpeedSpan& s : spans) fastest = std::max(fastest, s.speed);
  if (smoothing_ > 0) take_lowest_near(spans, fastest * smoothing_);

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
  for (std::size_t i = 0; i < n; ++i) {
    const auto& [length, speed, a] = spans[i];
    const double v0 = at[i], v1 = at[i + 1];
    const double peak = std::min(speed, std::sqrt(a * length + (v0 * v0 + v1 * v1) / 2));
    const double up = std::max(0.0, peak - v0) / a, down = std::max(0.0, peak - v1) / a;
    const double cruise = std::max(0.0, length - up * (v0 + peak) / 2 - down * (v1 + peak) / 2);
    add(up, v0, a);
    add(cruise / peak, peak, 0);
    add(down, peak, -a);
  }
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

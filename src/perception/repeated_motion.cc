#include "impedraw/perception/repeated_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace impedraw {

namespace {

constexpr double kBetweenPieces = 1.0 / 60.0;                   // half of a usual frame's time [s]
constexpr std::size_t kFewestOfAll = 60, kFewestOfPattern = 4;  // samples; of a pattern
constexpr double kMoves = 10.0;     // range of the samples in σ from which on there is a motion
constexpr double kUnlikely = 1e-9;  // share of the weights so far that counts no more

double at(std::span<const AxisSample> s, double time) noexcept {
  const auto next = std::lower_bound(s.begin() + 1, s.end() - 1, time,
                                     [](const AxisSample& a, double t) { return a.time < t; });
  const AxisSample &a = *(next - 1), &b = *next;
  return a.x + (time - a.time) / (b.time - a.time) * (b.x - a.x);
}

}  // namespace

std::optional<AxisPolynomial> RepeatedMotion::predict(std::span<const AxisSample> all) noexcept {
  if (all.size() < kFewestOfAll) return std::nullopt;
  const double now = all.back().time;
  std::size_t n = 1;
  while (n < all.size() && all[all.size() - 1 - n].time >= now - kPattern) ++n;
  if (n < kFewestOfPattern) return std::nullopt;
  const std::span<const AxisSample> pattern = all.last(n);
  double mean = 0.0, variance = 0.0, spread = 0.0;  // spread: Σ (x − x̄)²
  for (const AxisSample& s : pattern) {
    mean += s.x / static_cast<double>(n);
    variance += s.variance / static_cast<double>(n);
  }
  for (const AxisSample& s : pattern) spread += (s.x - mean) * (s.x - mean);
  const auto [low, high] = std::minmax_element(
      all.begin(), all.end(), [](const AxisSample& a, const AxisSample& b) { return a.x < b.x; });
  if (high->x - low->x < kMoves * std::sqrt(variance)) return std::nullopt;

  double weight = 0.0;
  std::array<double, 3> y{};  // Σ w s (x'(t') − x̄') now, after half of the span and after all
  for (double t = now - kSpan; t > all.front().time + kPattern; t -= kBetweenPieces) {
    double off = 0.0, square = spread, cross = 0.0;  // off: of the piece's mean from x̄
    for (const AxisSample& s : pattern) {
      const double b = at(all, t + s.time - now) - mean;
      off += b / static_cast<double>(n);
      square += b * b;
      cross += (s.x - mean) * b;
    }
    square -= static_cast<double>(n) * off * off;
    for (const double sign : {1.0, -1.0}) {
      const double w = std::exp(-(square - 2.0 * sign * cross) / (4.0 * variance));
      if (!(w > kUnlikely * weight)) continue;
      weight += w;
      for (std::size_t k = 0; k < y.size(); ++k)
        y[k] += w * sign * (at(all, t + 0.5 * kSpan * static_cast<double>(k)) - mean - off);
    }
  }
  if (!(weight > 0.0)) return std::nullopt;
  for (double& x : y) x = mean + x / weight;
  return AxisPolynomial{
      now, kSpan, {y[0], -3.0 * y[0] + 4.0 * y[1] - y[2], 2.0 * y[0] - 4.0 * y[1] + 2.0 * y[2]}};
}

}  // namespace impedraw

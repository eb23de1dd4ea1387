#include "impedraw/perception/repeated_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace impedraw {

namespace {

constexpr double kBetweenPieces = 1.0 / 60.0;  // half of a usual frame's time [s]
constexpr std::size_t kFewestOfAll = 60, kFewest = 4, kMost = 16;  // samples; of a pattern
constexpr double kMoves = 10.0;     // range of the samples in σ from which on there is a motion
constexpr double kUnlikely = 60.0;  // r² beyond the least, in σ², that counts no more

double at(std::span<const AxisSample> s, double time) noexcept {
  const auto next = std::lower_bound(s.begin() + 1, s.end() - 1, time,
                                     [](const AxisSample& a, double t) { return a.time < t; });
  const AxisSample &a = *(next - 1), &b = *next;
  return a.x + (time - a.time) / (b.time - a.time) * (b.x - a.x);
}

// Σ w s (x'(t') − x̄') at the prediction's nodes, and Σ w, against the likeliest piece so far.
struct Continuations {
  static constexpr int kNodes = AxisPolynomial::kTerms;
  double least = std::numeric_limits<double>::infinity(), weight = 0.0;
  std::array<double, kNodes> sum{};

  void add(double r, double sign, double scale, const std::array<double, kNodes>& after) noexcept {
    if (r < least) {
      const double fade = std::exp((r - least) / scale);
      weight *= fade;
      for (double& x : sum) x *= fade;
      least = r;
    }
    const double w = std::exp((least - r) / scale);
    weight += w;
    for (int k = 0; k < kNodes; ++k) sum[k] += w * sign * after[k];
  }
};

}  // namespace

std::optional<AxisPolynomial> RepeatedMotion::predict(std::span<const AxisSample> all) noexcept {
  if (all.size() < kFewestOfAll) return std::nullopt;
  const double now = all.back().time;
  std::size_t n = 1;
  while (n < kMost && all[all.size() - 1 - n].time >= now - kPattern) ++n;
  if (n < kFewest) return std::nullopt;
  const std::span<const AxisSample> pattern = all.last(n);
  const double share = 1.0 / static_cast<double>(n);
  double mean = 0.0, variance = 0.0;
  for (const AxisSample& s : pattern) {
    mean += share * s.x;
    variance += share * s.variance;
  }
  const auto [low, high] = std::minmax_element(
      all.begin(), all.end(), [](const AxisSample& a, const AxisSample& b) { return a.x < b.x; });
  if (high->x - low->x < kMoves * std::sqrt(variance)) return std::nullopt;

  Continuations found;
  std::array<double, kMost> then;
  for (double t = now - kSpan; t > all.front().time + kPattern; t -= kBetweenPieces) {
    double mean_then = 0.0, square = 0.0, cross = 0.0;
    for (std::size_t j = 0; j < n; ++j) {
      then[j] = at(all, t + pattern[j].time - now);
      mean_then += share * then[j];
    }
    for (std::size_t j = 0; j < n; ++j) {
      const double x = pattern[j].x - mean, y = then[j] - mean_then;
      square += x * x + y * y;
      cross += x * y;
    }
    if (square - 2.0 * std::abs(cross) > found.least + kUnlikely * variance) continue;
    std::array<double, Continuations::kNodes> after;
    for (int k = 0; k < Continuations::kNodes; ++k)
      after[k] = at(all, t + kSpan * AxisPolynomial::node(k)) - mean_then;
    for (const double sign : {1.0, -1.0})
      found.add(square - 2.0 * sign * cross, sign, 4.0 * variance, after);
  }
  if (!(found.weight > 0.0)) return std::nullopt;
  for (double& x : found.sum) x = mean + x / found.weight;
  return AxisPolynomial::through(now, kSpan, found.sum);
}

}  // namespace impedraw

// Population statistics as docs/metrics.md defines them. Each needs at least one value.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace impedraw {

inline double mean(const std::vector<double>& x) {
  return std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
}

inline double root_mean_square(const std::vector<double>& x) {
  return std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.0) /
                   static_cast<double>(x.size()));
}

// Population standard deviation: divides by n.
inline double standard_deviation(const std::vector<double>& x) {
  const double m = mean(x);
  double sum = 0.0;
  for (const double value : x) sum += (value - m) * (value - m);
  return std::sqrt(sum / static_cast<double>(x.size()));
}

inline double maximum(const std::vector<double>& x) {
  return *std::max_element(x.begin(), x.end());
}

// p in 0 … 1. Interpolates linearly between order statistics at position p (n − 1), as numpy does.
inline double percentile(std::vector<double> x, double p) {
  const double position = p * static_cast<double>(x.size() - 1);
  const auto k = static_cast<std::size_t>(position);
  std::nth_element(x.begin(), x.begin() + k, x.end());
  const double low = x[k];
  if (k + 1 == x.size()) return low;
  const double high = *std::min_element(x.begin() + k + 1, x.end());
  return low + (position - static_cast<double>(k)) * (high - low);
}

}  // namespace impedraw

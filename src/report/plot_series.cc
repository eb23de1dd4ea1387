#include "impedraw/report/plot_series.h"

#include <algorithm>
#include <cmath>

namespace impedraw {

Envelope envelope(std::span<const double> t, const std::function<double(std::size_t)>& v,
                  std::size_t points) {
  Envelope e;
  const std::size_t n = t.size(), bins = std::max<std::size_t>(1, points / 2);
  const auto add = [&](std::size_t i, double value) {
    e.t.push_back(t[i]);
    e.v.push_back(value);
  };
  if (n <= points) {
    for (std::size_t i = 0; i < n; ++i) add(i, v(i));
    return e;
  }
  for (std::size_t b = 0; b < bins; ++b) {
    const std::size_t begin = b * n / bins, end = (b + 1) * n / bins;
    std::size_t least = end, largest = end;
    double low = 0.0, high = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const double value = v(i);
      if (!std::isfinite(value)) continue;
      if (least == end || value < low) least = i, low = value;
      if (largest == end || value > high) largest = i, high = value;
    }
    if (least == end) {
      add(begin, LogRow::kNone);
    } else {
      add(std::min(least, largest), least < largest ? low : high);
      if (least != largest) add(std::max(least, largest), least < largest ? high : low);
    }
  }
  return e;
}

}  // namespace impedraw

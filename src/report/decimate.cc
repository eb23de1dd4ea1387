#include "impedraw/report/decimate.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace impedraw {

Line2d decimated(const Line2d& line, double tolerance) {
  constexpr double kPi = std::numbers::pi;
  Line2d out;
  if (line.empty()) return out;
  out.push_back(line.front());
  // The wedge, as angles from the direction `axis`. `open`: no limit yet.
  double axis = 0.0, low = -kPi, high = kPi, farthest = 0.0;
  bool open = true;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const auto from_last = [&] { return Eigen::Vector2d(line[i] - out.back()); };
    Eigen::Vector2d d = from_last();
    double distance = d.norm();
    const auto turn = [&] {
      return open ? 0.0 : std::remainder(std::atan2(d.y(), d.x()) - axis, 2.0 * kPi);
    };
    double angle = turn();
    if (distance < farthest || angle < low || angle > high) {
      out.push_back(line[i - 1]);
      low = -kPi, high = kPi, farthest = 0.0, open = true;
      d = from_last();
      distance = d.norm();
      angle = 0.0;
    }
    farthest = distance;
    if (distance <= tolerance) continue;  // every direction passes it
    if (open) axis = std::atan2(d.y(), d.x());
    open = false;
    const double half = std::asin(tolerance / distance);
    low = std::max(low, angle - half);
    high = std::min(high, angle + half);
  }
  if (line.size() > 1) out.push_back(line.back());
  return out;
}

double decimate_to(std::vector<Line2d>& lines, double finest, std::size_t most) {
  std::vector<Line2d> thin(lines.size());
  for (double tolerance = finest;; tolerance *= std::numbers::sqrt2) {
    std::size_t points = 0;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      thin[k] = decimated(lines[k], tolerance);
      points += thin[k].size();
    }
    if (points > most && tolerance < 200.0 * finest) continue;
    lines.swap(thin);
    return tolerance;
  }
}

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

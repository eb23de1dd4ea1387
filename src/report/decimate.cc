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

}  // namespace impedraw

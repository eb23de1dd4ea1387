#include "impedraw/drawing/dashes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/core.h>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr double kMostDashes = 1e6;
constexpr double kSame = 1e-6;  // fraction of the pattern; less is rounding

double period_of(const Dash& dash) {
  double period = 0;
  bool valid =
      dash.lengths.size() % 2 == 0 && std::isfinite(dash.offset) && dash.to_pattern.allFinite();
  for (const double length : dash.lengths) {
    valid = valid && length >= 0;
    period += length;
  }
  if (!valid || !(period > 0) || !std::isfinite(period)) {
    throw InputError(
        "dashes: an even number of lengths, none negative and not all 0, and a finite offset are "
        "needed");
  }
  return period;
}

// A line parametrised by the length from its start, in the pattern's unit.
class Walk {
 public:
  Walk(const std::vector<Vector2d>& line, const Eigen::Matrix2d& to_pattern) : line_(line) {
    for (std::size_t i = 1; i < line.size(); ++i)
      way_.push_back(way_.back() + (to_pattern * (line[i] - line[i - 1])).norm());
  }

  double length() const { return way_.back(); }

  Vector2d at(double s) const {
    const auto next = std::lower_bound(way_.begin() + 1, way_.end() - 1, s) - way_.begin();
    const double span = way_[next] - way_[next - 1];
    const double t = span > 0 ? std::clamp((s - way_[next - 1]) / span, 0.0, 1.0) : 1.0;
    return t == 1.0 ? line_[next] : Vector2d(line_[next - 1] + t * (line_[next] - line_[next - 1]));
  }

  // The part of the line between lengths a and b.
  std::vector<Vector2d> part(double a, double b) const {
    std::vector<Vector2d> points{at(a)};
    const auto first = std::upper_bound(way_.begin(), way_.end(), a) - way_.begin();
    for (auto i = first; i < std::ssize(way_) && way_[i] < b; ++i) add(points, line_[i]);
    add(points, at(b));
    return points;
  }

  static void add(std::vector<Vector2d>& points, const Vector2d& p) {
    if (points.back() != p) points.push_back(p);
  }

 private:
  const std::vector<Vector2d>& line_;
  std::vector<double> way_{0.0};
};

void break_up(const Stroke& stroke, const Dash& dash, std::vector<Stroke>& result) {
  const double period = period_of(dash), least = kSame * period;
  const auto add = [&](std::vector<Vector2d> points, bool closed) -> Stroke& {
    result.push_back(like(stroke, std::move(points), closed));
    result.back().dash = -1;
    return result.back();
  };
  // A dot lies at the pattern's start, which SVG always draws.
  if (stroke.points.size() < 2) {
    add(stroke.points, false);
    return;
  }
  const Walk walk(stroke.points, dash.to_pattern);
  const double length = walk.length();
  if (length / period * static_cast<double>(dash.lengths.size()) / 2 +
          static_cast<double>(result.size()) >
      kMostDashes) {
    throw InputError(fmt::format(
        "dashes: a line of {:.6g} mm would be split into {:.3g} dashes; at most {:.0e} are drawn",
        length / dash.to_pattern.norm() * std::sqrt(2.0), length / period, kMostDashes));
  }
  std::size_t entry = 0;
  double in_entry = std::fmod(dash.offset, period);
  if (in_entry < 0) in_entry += period;
  while (in_entry > 0 && in_entry >= dash.lengths[entry]) {
    in_entry -= dash.lengths[entry];
    entry = (entry + 1) % dash.lengths.size();
  }
  std::vector<std::pair<double, double>> drawn;
  for (double s = 0; s < length;) {
    const double end = s + dash.lengths[entry] - in_entry, stop = std::min(end, length);
    if (entry % 2 == 0) {
      const bool touches =
          !drawn.empty() && s > drawn.back().first && s - drawn.back().second < least;
      if (dash.lengths[entry] == 0 && dash.dots)
        drawn.emplace_back(s, s);
      else if (stop - s > least && touches)
        drawn.back().second = stop;  // the gap between them has zero length
      else if (stop - s > least)
        drawn.emplace_back(s, stop);
    }
    s = end;
    in_entry = 0;
    entry = (entry + 1) % dash.lengths.size();
  }
  if (drawn.empty()) return;
  if (stroke.closed && drawn.size() == 1 && drawn[0].first == 0 && drawn[0].second >= length) {
    add(stroke.points, true);
    return;
  }
  const bool over_the_start = stroke.closed && drawn.size() > 1 && drawn.front().first == 0 &&
                              drawn.front().second > least && drawn.back().second >= length &&
                              drawn.back().first < length - least;
  const std::size_t first = over_the_start ? 1 : 0;
  for (std::size_t i = first; i < drawn.size(); ++i) {
    Stroke& part = add(walk.part(drawn[i].first, drawn[i].second), false);
    if (over_the_start && i + 1 == drawn.size()) {
      for (const Vector2d& p : walk.part(drawn[0].first, drawn[0].second))
        Walk::add(part.points, p);
    }
  }
}

}  // namespace

std::vector<Stroke> dashed(const std::vector<Stroke>& strokes, const std::vector<Dash>& dashes) {
  std::vector<Stroke> result;
  for (const Stroke& stroke : strokes) {
    if (stroke.dash < 0)
      result.push_back(stroke);
    else
      break_up(stroke, dashes.at(static_cast<std::size_t>(stroke.dash)), result);
  }
  return result;
}

Dash dash_from(Dash dash, const std::vector<Vector2d>& line, double start) {
  for (std::size_t i = 1; i < line.size() && start > 0; ++i) {
    const Vector2d along = line[i] - line[i - 1];
    const double part = std::min(start, along.norm());
    dash.offset += part * (dash.to_pattern * along.normalized()).norm();
    start -= part;
  }
  return dash;
}

}  // namespace impedraw

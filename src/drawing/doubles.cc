#include "impedraw/drawing/doubles.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "impedraw/common/cross.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr double kParallel = 0.035;      // [rad]
constexpr double kLeastRun = 4;          // run that is removed, in distances
constexpr double kMostPairs = 1e8;       // then what is left stays as it is
constexpr double kCellsPerStroke = 1e4;  // a longer one's segments are looked for in larger cells

struct DrawnPart {
  Vector2d a, b;
  int layer;
};

// Segments that are drawn, by the cells that they pass.
class Drawn {
 public:
  double pairs = 0;  // that were compared

  explicit Drawn(double cell) : cell_(cell) {}

  void add(const DrawnPart& segment) {
    each_cell(segment.a, segment.b,
              [&](long key) { cells_[key].push_back(static_cast<int>(segments_.size())); });
    segments_.push_back(segment);
  }

  // The shares of a → b that lie on segments within the distance.
  std::vector<std::pair<double, double>> on(const DrawnPart& s, double distance) {
    std::vector<std::pair<double, double>> shares;
    const Vector2d along = s.b - s.a;
    const double length = along.norm();
    std::vector<int> near;
    each_cell(s.a, s.b, [&](long key) {
      const auto found = cells_.find(key);
      if (found != cells_.end())
        near.insert(near.end(), found->second.begin(), found->second.end());
    });
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    pairs += static_cast<double>(near.size());
    for (const int i : near) {
      const DrawnPart& other = segments_[i];
      const Vector2d way = other.b - other.a;
      if (other.layer != s.layer || std::abs(cross(along, way)) > kParallel * length * way.norm())
        continue;
      const double side_a = cross(along, Vector2d(other.a - s.a)) / length,
                   side_b = cross(along, Vector2d(other.b - s.a)) / length;
      if (std::max(std::abs(side_a), std::abs(side_b)) > distance) continue;
      const auto [from, to] = std::minmax({along.dot(other.a - s.a) / (length * length),
                                           along.dot(other.b - s.a) / (length * length)});
      if (from < 1 && to > 0) shares.emplace_back(std::max(from, 0.0), std::min(to, 1.0));
    }
    std::sort(shares.begin(), shares.end());
    return shares;
  }

 private:
  template <class Do>
  void each_cell(const Vector2d& a, const Vector2d& b, Do&& act) const {
    const Vector2d low = a.cwiseMin(b) / cell_, high = a.cwiseMax(b) / cell_;
    for (double y = std::floor(low.y() - 0.1); y <= high.y() + 0.1; ++y) {
      // only the cells beside the line
      const double slope = b.y() - a.y();
      double left = low.x(), right = high.x();
      if (std::abs(slope) > cell_) {
        const double t0 = ((y - 0.2) * cell_ - a.y()) / slope,
                     t1 = ((y + 1.2) * cell_ - a.y()) / slope;
        const double x0 = (a.x() + t0 * (b.x() - a.x())) / cell_,
                     x1 = (a.x() + t1 * (b.x() - a.x())) / cell_;
        left = std::max(left, std::min(x0, x1));
        right = std::min(right, std::max(x0, x1));
      }
      for (double x = std::floor(left - 0.1); x <= right + 0.1; ++x)
        act(static_cast<long>(x) * 4'000'037L + static_cast<long>(y));
    }
  }

  double cell_;
  std::vector<DrawnPart> segments_;
  std::unordered_map<long, std::vector<int>> cells_;
};

}  // namespace

double drop_doubles(std::vector<Stroke>& strokes, double distance_mm) {
  Eigen::AlignedBox2d box;
  for (const Stroke& stroke : strokes) {
    for (const Vector2d& p : stroke.points) box.extend(p);
  }
  if (box.isEmpty() || !(distance_mm > 0)) return 0;
  Drawn drawn(std::max(10 * distance_mm, box.diagonal().norm() / kCellsPerStroke));
  double removed = 0;
  std::vector<Stroke> kept;
  for (Stroke& stroke : strokes) {
    if (stroke.dash >= 0 || stroke.points.size() < 2 || drawn.pairs > kMostPairs) {
      kept.push_back(std::move(stroke));
      continue;
    }
    const double distance =
        stroke.width > 0 ? std::min(distance_mm, stroke.width / 2) : distance_mm;
    // The line as spans that are doubled or not, each with its points.
    struct Span {
      bool doubled;
      std::vector<Vector2d> points;
      double length;
    };
    std::vector<Span> spans;
    const auto add = [&](bool doubled, const Vector2d& from, const Vector2d& to) {
      if (spans.empty() || spans.back().doubled != doubled) spans.push_back({doubled, {from}, 0});
      spans.back().length += (to - from).norm();
      spans.back().points.push_back(to);
    };
    for (std::size_t i = 1; i < stroke.points.size(); ++i) {
      const Vector2d &a = stroke.points[i - 1], &b = stroke.points[i];
      const auto at = [&](double t) { return t == 0 ? a : t == 1 ? b : Vector2d(a + t * (b - a)); };
      double done = 0, alone = 0;  // shares of the segment
      for (const auto& [from, to] : drawn.on({a, b, stroke.layer}, distance)) {
        if (from > done) {
          add(false, at(done), at(from));
          alone += from - done;
        }
        if (to > std::max(done, from)) add(true, at(std::max(done, from)), at(to));
        done = std::max(done, to);
      }
      if (done < 1) add(false, at(done), b);
      alone += 1 - done;
      if (alone > 0) drawn.add({a, b, stroke.layer});
    }
    const auto is_long = [&](const Span& span) {
      return span.doubled && span.length > kLeastRun * distance;
    };
    if (std::none_of(spans.begin(), spans.end(), is_long)) {
      kept.push_back(std::move(stroke));
      continue;
    }
    // Crumbs beside what is removed go with it.
    const auto is_double = [&](const Span& span) {
      return is_long(span) || span.length < distance;
    };
    bool goes_on = false;
    for (const Span& span : spans) {
      if (is_double(span)) {
        removed += span.length;
        goes_on = false;
        continue;
      }
      if (!goes_on) kept.push_back(like(stroke, {span.points.front()}));
      kept.back().points.insert(kept.back().points.end(), span.points.begin() + 1,
                                span.points.end());
      goes_on = true;
    }
    const bool over_the_start =
        stroke.closed && spans.size() > 2 && !is_double(spans.front()) && !is_double(spans.back());
    if (over_the_start) {
      const auto whole = [&](const Stroke& s) { return s.points.front() == stroke.points.front(); };
      const auto first = std::find_if(kept.rbegin(), kept.rend(), whole);
      if (first != kept.rend() && &*first != &kept.back()) {
        kept.back().points.insert(kept.back().points.end(), first->points.begin() + 1,
                                  first->points.end());
        kept.erase(std::next(first).base());
      }
    }
  }
  strokes = std::move(kept);
  return removed;
}

}  // namespace impedraw

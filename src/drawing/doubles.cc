#include "impedraw/drawing/doubles.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "impedraw/common/cross.h"
#include "impedraw/drawing/polyline.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr double kParallel = 0.035;  // [rad]
constexpr int kDirections = 90;      // of half a turn, each as wide as kParallel
constexpr double kLeastRun = 4;      // run that is removed, in distances
constexpr int kNoLayer = -1;
constexpr double kMostPairs = 1e8;  // then what is left stays as it is
constexpr double kLongCells = 10;   // along the drawing's diagonal

struct DrawnPart {
  Vector2d a, b;
  int layer;
};

// Segments that are drawn, by direction and by cells that are long in that direction.
class Drawn {
 public:
  double pairs = 0;  // that were compared

  Drawn(double wide, double longer) : size_(longer, wide) {}

  int add(const DrawnPart& segment) {
    each_cell(segment, direction_of(segment), 0,
              [&](long key) { cells_[key].push_back(static_cast<int>(segments_.size())); });
    segments_.push_back(segment);
    return static_cast<int>(segments_.size()) - 1;
  }

  void forget(int segment) { segments_[segment].layer = kNoLayer; }

  // The shares of a → b that lie on segments within the distance.
  std::vector<std::pair<double, double>> on(const DrawnPart& s, double distance) {
    std::vector<std::pair<double, double>> shares;
    const Vector2d along = s.b - s.a;
    const double length = along.norm();
    std::vector<int> near;
    for (int turn = -1; turn <= 1; ++turn) {
      const int direction = (direction_of(s) + turn + kDirections) % kDirections;
      each_cell(s, direction, distance, [&](long key) {
        const auto found = cells_.find(key);
        if (found != cells_.end())
          near.insert(near.end(), found->second.begin(), found->second.end());
      });
    }
    pairs += static_cast<double>(near.size());
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
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
  static int direction_of(const DrawnPart& s) {
    const Vector2d along = s.b - s.a;
    const double share = std::atan2(along.y(), along.x()) / std::numbers::pi;  // -1 to 1
    return (static_cast<int>(std::lround(share * kDirections)) + kDirections) % kDirections;
  }

  template <class Do>
  void each_cell(const DrawnPart& s, int direction, double spare, Do&& act) const {
    const double angle = direction * std::numbers::pi / kDirections;
    const Vector2d along(std::cos(angle), std::sin(angle));
    const Vector2d a(along.dot(s.a), cross(along, s.a)), b(along.dot(s.b), cross(along, s.b));
    const Vector2d low = (a.cwiseMin(b).array() - spare) / size_.array(),
                   high = (a.cwiseMax(b).array() + spare) / size_.array();
    for (double y = std::floor(low.y()); y <= high.y(); ++y) {
      for (double x = std::floor(low.x()); x <= high.x(); ++x)
        act((static_cast<long>(x) * 4'000'037L + static_cast<long>(y)) * kDirections + direction);
    }
  }

  Vector2d size_;  // of a cell [mm], along and across
  std::vector<DrawnPart> segments_;
  std::unordered_map<long, std::vector<int>> cells_;
};

// Strokes that lie on no line: short ones that no other's box comes near.
std::vector<char> lone_strokes(const std::vector<Stroke>& strokes, double distance) {
  std::vector<Eigen::AlignedBox2d> boxes(strokes.size());
  std::vector<std::size_t> by_x(strokes.size());
  std::iota(by_x.begin(), by_x.end(), 0);
  for (std::size_t i = 0; i < strokes.size(); ++i)
    for (const Vector2d& p : strokes[i].points) boxes[i].extend(p);
  std::sort(by_x.begin(), by_x.end(),
            [&](std::size_t i, std::size_t j) { return boxes[i].min().x() < boxes[j].min().x(); });
  std::vector<char> lone(strokes.size(), true);
  double pairs = 0;
  for (std::size_t k = 0; k < by_x.size(); ++k) {
    const std::size_t i = by_x[k];
    const Vector2d low = boxes[i].min().array() - distance,
                   high = boxes[i].max().array() + distance;
    for (std::size_t next = k + 1; next < by_x.size(); ++next, ++pairs) {
      const std::size_t j = by_x[next];
      if (boxes[j].min().x() > high.x()) break;
      if (boxes[j].min().y() <= high.y() && boxes[j].max().y() >= low.y())
        lone[i] = lone[j] = false;
    }
    if (pairs > kMostPairs) return std::vector<char>(strokes.size(), false);
  }
  for (std::size_t i = 0; i < strokes.size(); ++i)
    lone[i] = lone[i] && length(strokes[i].points) < 2 * kLeastRun * distance;
  return lone;
}

}  // namespace

double drop_doubles(std::vector<Stroke>& strokes, double distance_mm) {
  const Eigen::AlignedBox2d box = bounds_of(strokes);
  if (box.isEmpty() || !(distance_mm > 0)) return 0;
  const double diagonal = box.diagonal().norm();
  Drawn drawn(std::max(10 * distance_mm, diagonal / 1e4), diagonal / kLongCells);
  double removed = 0;
  // The widest line stays, in its place.
  std::vector<std::size_t> by_width(strokes.size());
  std::iota(by_width.begin(), by_width.end(), 0);
  std::stable_sort(by_width.begin(), by_width.end(), [&](std::size_t a, std::size_t b) {
    return strokes[a].width > strokes[b].width;
  });
  const std::vector<char> lone = lone_strokes(strokes, distance_mm);
  std::vector<std::vector<Stroke>> parts(strokes.size());
  for (const std::size_t index : by_width) {
    Stroke& stroke = strokes[index];
    std::vector<Stroke>& kept = parts[index];
    if (stroke.dash >= 0 || stroke.points.size() < 2 || drawn.pairs > kMostPairs || lone[index]) {
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
      std::vector<int> drawn;
    };
    std::vector<Span> spans;
    const auto add = [&](bool doubled, const Vector2d& from, const Vector2d& to) {
      if (spans.empty() || spans.back().doubled != doubled)
        spans.push_back({doubled, {from}, 0, {}});
      spans.back().length += (to - from).norm();
      spans.back().points.push_back(to);
    };
    for (std::size_t i = 1; i < stroke.points.size(); ++i) {
      const Vector2d &a = stroke.points[i - 1], &b = stroke.points[i];
      const auto at = [&](double t) { return t == 0 ? a : t == 1 ? b : Vector2d(a + t * (b - a)); };
      double done = 0;  // share of the segment
      const auto draw = [&](double to) {
        add(false, at(done), at(to));
        spans.back().drawn.push_back(drawn.add({at(done), at(to), stroke.layer}));
      };
      for (const auto& [from, to] : drawn.on({a, b, stroke.layer}, distance)) {
        if (from > done) draw(from);
        if (to > std::max(done, from)) add(true, at(std::max(done, from)), at(to));
        done = std::max(done, to);
      }
      if (done < 1) draw(1);
    }
    // Crumbs beside what is doubled go with it.
    std::vector<Span> joined;
    for (Span& span : spans) {
      span.doubled = span.doubled || (spans.size() > 1 && span.length < 2 * distance);
      if (joined.empty() || joined.back().doubled != span.doubled) {
        joined.push_back(std::move(span));
        continue;
      }
      Span& before = joined.back();
      before.points.insert(before.points.end(), span.points.begin() + 1, span.points.end());
      before.drawn.insert(before.drawn.end(), span.drawn.begin(), span.drawn.end());
      before.length += span.length;
    }
    spans = std::move(joined);
    const auto is_double = [&](const Span& span) {
      return span.doubled && span.length > kLeastRun * distance;
    };
    if (std::none_of(spans.begin(), spans.end(), is_double)) {
      kept.push_back(std::move(stroke));
      continue;
    }
    bool goes_on = false;
    for (const Span& span : spans) {
      if (is_double(span)) {
        removed += span.length;
        for (const int i : span.drawn) drawn.forget(i);
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
  strokes.clear();
  for (std::vector<Stroke>& kept : parts)
    std::move(kept.begin(), kept.end(), std::back_inserter(strokes));
  return removed;
}

}  // namespace impedraw

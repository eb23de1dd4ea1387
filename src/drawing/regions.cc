#include "impedraw/drawing/regions.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <polyclipping/clipper.hpp>

#include "impedraw/common/cross.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
namespace cl = ClipperLib;
constexpr double kRegionFineness = 5e8;  // of half the box; from 2^30 Clipper needs wider integers
constexpr double kLeastFineness = 1e5;   // steps per millimetre, then with wider integers
constexpr double kMostCrossings = 4e6;   // of one operation, which take 200 bytes each
constexpr double kWidest = 1e17;         // steps of a stroke: its mitres stay in Clipper's range
constexpr double kMitre = 2 * kMostReach;  // SVG's limit
constexpr double kRound = 2e-3;            // of a round cap's chords, of the stroke's width
constexpr double kRoundInset = 5e-3;       // of an inset's chords about corners, of its distance
constexpr double kClean = 1e-3;            // of points that an inset does without, of its distance

cl::Paths to_clipper(const Outlines& outlines, const Vector2d& centre, double fineness) {
  cl::Paths paths;
  for (const auto& outline : outlines) {
    paths.emplace_back();
    for (const Vector2d& p : outline) {
      const Vector2d q = (p - centre) * fineness;
      paths.back().emplace_back(std::llround(q.x()), std::llround(q.y()));
    }
  }
  return paths;
}

Outlines from_clipper(const cl::Paths& paths, const Vector2d& centre, double fineness) {
  Outlines outlines;
  for (const cl::Path& path : paths) {
    outlines.emplace_back();
    for (const cl::IntPoint& p : path)
      outlines.back().push_back(
          centre + Vector2d(static_cast<double>(p.X), static_cast<double>(p.Y)) / fineness);
  }
  return outlines;
}

// Before an operation: what it takes grows with the edges that cross.
void require_few_crossings(const std::vector<cl::Path>& paths) {
  struct Edge {
    Vector2d a, b;
    double low, high;
  };
  std::vector<Edge> edges;
  for (const cl::Path& path : paths) {
    for (std::size_t i = 0; i < path.size(); ++i) {
      const cl::IntPoint &p = path[i], &q = path[(i + 1) % path.size()];
      const Vector2d a(static_cast<double>(p.X), static_cast<double>(p.Y)),
          b(static_cast<double>(q.X), static_cast<double>(q.Y));
      edges.push_back({a, b, std::min(a.y(), b.y()), std::max(a.y(), b.y())});
    }
  }
  const double count = static_cast<double>(edges.size());
  if (count * count / 2 < kMostCrossings) return;
  std::sort(edges.begin(), edges.end(), [](const auto& a, const auto& b) { return a.low < b.low; });
  double crossings = 0;
  const auto apart = [](const Edge& edge, const Edge& other) {  // on the two sides of its line
    const Vector2d along = edge.b - edge.a;
    return (cross(along, Vector2d(other.a - edge.a)) > 0) !=
           (cross(along, Vector2d(other.b - edge.a)) > 0);
  };
  std::vector<Edge> alive;
  for (const Edge& edge : edges) {
    std::erase_if(alive, [&](const Edge& other) { return other.high < edge.low; });
    for (const Edge& other : alive) crossings += apart(edge, other) && apart(other, edge);
    alive.push_back(edge);
    if (crossings > kMostCrossings) throw InputError("outlines cross one another too often");
  }
}

}  // namespace

Eigen::AlignedBox2d outlines_box(const Outlines& outlines) {
  Eigen::AlignedBox2d box;
  for (const auto& outline : outlines) {
    for (const Vector2d& p : outline) box.extend(p);
  }
  return box;
}

double enclosed_area(const Outlines& outlines) {
  double twice = 0;
  for (const auto& outline : outlines) {
    for (std::size_t i = 0; i < outline.size(); ++i)
      twice += cross(Vector2d(outline[i] - outline[0]),
                     Vector2d(outline[(i + 1) % outline.size()] - outline[0]));
  }
  return std::abs(twice) / 2;
}

RegionMath::RegionMath(const Eigen::AlignedBox2d& box)
    : centre_(box.center()),
      fineness_(
          std::max(kRegionFineness / std::max(box.sizes().maxCoeff() / 2, 1e-3), kLeastFineness)) {}

Outlines RegionMath::run(int operation, const Outlines& a, const Outlines& b, bool even_odd) const {
  cl::Paths all = to_clipper(a, centre_, fineness_), result;
  const cl::Paths others = to_clipper(b, centre_, fineness_);
  cl::Clipper clipper;
  clipper.AddPaths(all, cl::ptSubject, true);
  clipper.AddPaths(others, cl::ptClip, true);
  all.insert(all.end(), others.begin(), others.end());
  require_few_crossings(all);
  clipper.Execute(static_cast<cl::ClipType>(operation), result,
                  even_odd ? cl::pftEvenOdd : cl::pftNonZero, cl::pftNonZero);
  return from_clipper(result, centre_, fineness_);
}

Outlines RegionMath::stroked(const std::vector<Vector2d>& line, double width, bool closed,
                             bool round) const {
  width = std::min(width, kWidest / fineness_);
  cl::ClipperOffset offset(kMitre, kRound * width * fineness_);
  offset.AddPaths(to_clipper({line}, centre_, fineness_), round ? cl::jtRound : cl::jtMiter,
                  closed  ? cl::etClosedLine
                  : round ? cl::etOpenRound
                          : cl::etOpenButt);
  cl::Paths result;
  offset.Execute(result, width / 2 * fineness_);
  return from_clipper(result, centre_, fineness_);
}

Outlines RegionMath::inset(const Outlines& region, double distance) const {
  cl::ClipperOffset offset(kMitre, kRoundInset * distance * fineness_);
  offset.AddPaths(to_clipper(region, centre_, fineness_), cl::jtRound, cl::etClosedPolygon);
  cl::Paths result;
  offset.Execute(result, -distance * fineness_);
  // Without it, an inset of an inset has ever more points about concave corners.
  cl::CleanPolygons(result, kClean * distance * fineness_);
  return from_clipper(result, centre_, fineness_);
}

Outlines RegionMath::region(const Area& area) const {
  return run(cl::ctUnion, area.outlines, {}, area.even_odd);
}
Outlines RegionMath::united(const Outlines& a, const Outlines& b) const {
  return run(cl::ctUnion, a, b, false);
}
Outlines RegionMath::common(const Outlines& a, const Outlines& b) const {
  return run(cl::ctIntersection, a, b, false);
}
Outlines RegionMath::without(const Outlines& a, const Outlines& b) const {
  return run(cl::ctDifference, a, b, false);
}

namespace {
constexpr double kBeyond = 2e-9;  // crossings beside an edge's end count, as a share of it
}

RegionIndex::RegionIndex(const Outlines& region) : box_(outlines_box(region)) {
  double climbed = 0;
  for (const auto& outline : region) {
    for (std::size_t i = 0; i < outline.size(); ++i) {
      edges_.push_back({outline[i], outline[(i + 1) % outline.size()]});
      climbed += std::abs(edges_.back().b.y() - edges_.back().a.y());
      widest_ = std::max(widest_, std::abs(edges_.back().b.x() - edges_.back().a.x()));
    }
  }
  if (edges_.empty()) return;
  std::sort(edges_.begin(), edges_.end(),
            [](const Edge& a, const Edge& b) { return a.left() < b.left(); });
  const double tall = box_.sizes().y(), count = static_cast<double>(edges_.size());
  // An edge stands in about four strips.
  const double strips = std::clamp(4 * count * tall / std::max(climbed, 1e-9), 1.0, count);
  starts_.resize(static_cast<std::size_t>(strips) + 1);
  height_ = std::max(tall / std::floor(strips), 1e-12);
  const auto each_strip = [&](const auto& act) {
    for (std::size_t i = edges_.size(); i-- > 0;) {
      const auto [low, high] = std::minmax(edges_[i].a.y(), edges_[i].b.y());
      for (std::size_t s = strip_of(low), last = strip_of(high); s <= last; ++s)
        act(starts_[s], static_cast<int>(i));
    }
  };
  each_strip([](std::size_t& edges, int) { ++edges; });
  std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
  in_strips_.resize(starts_.back());
  each_strip([this](std::size_t& end, int edge) { in_strips_[--end] = edge; });
}

std::size_t RegionIndex::strip_of(double y) const {
  const double last = static_cast<double>(starts_.size() - 2);
  return static_cast<std::size_t>(std::clamp((y - box_.min().y()) / height_, 0.0, last));
}

std::span<const int> RegionIndex::reaching(std::size_t strip, double x) const {
  const int* const first = in_strips_.data();
  const std::span edges(first + starts_[strip], first + starts_[strip + 1]);
  const double from = x - (1.0 + kBeyond) * widest_;
  const auto is_left = [this](int i, double of) { return edges_[i].left() < of; };
  return {std::lower_bound(edges.begin(), edges.end(), from, is_left), edges.end()};
}

bool RegionIndex::inside(const Vector2d& p, bool even_odd) const {
  if (edges_.empty() || !box_.contains(p)) return false;
  int winding = 0;
  for (const int i : reaching(strip_of(p.y()), p.x())) {
    const Edge& e = edges_[i];
    if ((e.a.y() <= p.y()) == (e.b.y() <= p.y())) continue;
    const double side = cross(Vector2d(e.b - e.a), Vector2d(p - e.a));
    if (e.a.y() <= p.y() ? side > 0 : side < 0) winding += e.a.y() <= p.y() ? 1 : -1;
  }
  return even_odd ? winding % 2 != 0 : winding != 0;
}

void RegionIndex::crossings(const Vector2d& a, const Vector2d& b, std::vector<double>& at) const {
  if (edges_.empty()) return;
  const Eigen::AlignedBox2d box(a.cwiseMin(b), a.cwiseMax(b));
  if (!box.intersects(box_)) return;
  for (std::size_t s = strip_of(box.min().y()), last = strip_of(box.max().y()); s <= last; ++s) {
    for (const int i : reaching(s, box.min().x())) {
      if (edges_[i].left() > box.max().x() + kBeyond * widest_) break;
      const Vector2d along = b - a, edge = edges_[i].b - edges_[i].a, to = edges_[i].a - a;
      const double turn = cross(along, edge);
      if (turn == 0) continue;
      const double t = cross(to, edge) / turn, u = cross(to, along) / turn;
      if (t > 0 && t < 1 && u >= -1e-9 && u <= 1 + 1e-9) at.push_back(t);
    }
  }
}

}  // namespace impedraw

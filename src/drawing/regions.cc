#include "impedraw/drawing/regions.h"

#include <algorithm>
#include <cmath>

#include <polyclipping/clipper.hpp>

#include "impedraw/common/cross.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
namespace cl = ClipperLib;
constexpr double kRegionFineness = 5e8;  // of half the box; from 2^30 Clipper needs wider integers
constexpr double kLeastFineness = 1e5;   // steps per millimetre, then with wider integers
constexpr double kMostCrossings = 1e7;   // of one operation, which take 100 bytes each
constexpr double kFewPairs = 50, kPerCrossing = 50;
constexpr double kPerEdge = 100, kPerOperation = 2000;  // what they cost, in pairs

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

struct EdgeBox {
  double low, high, left, right;
};

// Charges an operation before it runs: pairs of edges beside each other are what the sweep handles,
// and those whose boxes overlap may cross and take memory.
void charge(const std::vector<cl::Path>& paths, Effort& effort) {
  std::vector<EdgeBox> edges;
  for (const cl::Path& path : paths) {
    for (std::size_t i = 0; i < path.size(); ++i) {
      const cl::IntPoint &p = path[i], &q = path[(i + 1) % path.size()];
      const auto [low, high] = std::minmax(p.Y, q.Y);
      const auto [left, right] = std::minmax(p.X, q.X);
      edges.push_back({static_cast<double>(low), static_cast<double>(high),
                       static_cast<double>(left), static_cast<double>(right)});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const auto& a, const auto& b) { return a.low < b.low; });
  std::vector<double> ends;
  for (const EdgeBox& edge : edges) ends.push_back(edge.high);
  std::sort(ends.begin(), ends.end());
  double pairs = 0;
  std::size_t ended = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    while (ends[ended] < edges[i].low) ++ended;
    pairs += static_cast<double>(i - ended);
  }
  effort.spend(kPerOperation + kPerEdge * static_cast<double>(edges.size()) + pairs);
  if (pairs <= kFewPairs * static_cast<double>(edges.size())) return;
  double crossings = 0;
  std::vector<EdgeBox> alive;
  for (const EdgeBox& edge : edges) {
    std::erase_if(alive, [&](const EdgeBox& other) { return other.high < edge.low; });
    for (const EdgeBox& other : alive)
      crossings += other.left <= edge.right && edge.left <= other.right;
    alive.push_back(edge);
    if (crossings > kMostCrossings) effort.spend(INFINITY);
  }
  effort.spend(kPerCrossing * crossings);
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

void Effort::spend(double pairs) {
  left -= pairs;
  if (left >= 0) return;
  throw InputError(
      "what its fills, clip paths and masks hide takes too long to find; drawing.visible: all "
      "draws "
      "it as if nothing were hidden");
}

RegionMath::RegionMath(const Eigen::AlignedBox2d& box, Effort& effort)
    : centre_(box.center()),
      fineness_(
          std::max(kRegionFineness / std::max(box.sizes().maxCoeff() / 2, 1e-3), kLeastFineness)),
      effort_(effort) {}

Outlines RegionMath::run(int operation, const Outlines& a, const Outlines& b, bool even_odd) const {
  cl::Paths all = to_clipper(a, centre_, fineness_), result;
  const cl::Paths others = to_clipper(b, centre_, fineness_);
  cl::Clipper clipper;
  clipper.AddPaths(all, cl::ptSubject, true);
  clipper.AddPaths(others, cl::ptClip, true);
  all.insert(all.end(), others.begin(), others.end());
  charge(all, effort_);
  clipper.Execute(static_cast<cl::ClipType>(operation), result,
                  even_odd ? cl::pftEvenOdd : cl::pftNonZero, cl::pftNonZero);
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

RegionIndex::RegionIndex(const Outlines& region, Effort& effort)
    : box_(outlines_box(region)), effort_(&effort) {
  double climbed = 0;
  for (const auto& outline : region) {
    for (std::size_t i = 0; i < outline.size(); ++i) {
      edges_.push_back({outline[i], outline[(i + 1) % outline.size()]});
      climbed += std::abs(edges_.back().b.y() - edges_.back().a.y());
    }
  }
  if (edges_.empty()) return;
  const double tall = box_.sizes().y(), count = static_cast<double>(edges_.size());
  // An edge stands in about eight strips.
  const double strips = std::clamp(8 * count * tall / std::max(climbed, 1e-9), 1.0, count);
  strips_.resize(static_cast<std::size_t>(strips));
  height_ = std::max(tall / static_cast<double>(strips_.size()), 1e-12);
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const auto [low, high] = std::minmax(edges_[i].a.y(), edges_[i].b.y());
    for (std::size_t s = strip_of(low), last = strip_of(high); s <= last; ++s)
      strips_[s].push_back(static_cast<int>(i));
  }
}

std::size_t RegionIndex::strip_of(double y) const {
  const double last = static_cast<double>(strips_.size() - 1);
  return static_cast<std::size_t>(std::clamp((y - box_.min().y()) / height_, 0.0, last));
}

bool RegionIndex::inside(const Vector2d& p) const {
  if (edges_.empty() || !box_.contains(p)) return false;
  const std::vector<int>& strip = strips_[strip_of(p.y())];
  effort_->spend(static_cast<double>(strip.size()));
  int winding = 0;
  for (const int i : strip) {
    const Edge& e = edges_[i];
    if ((e.a.y() <= p.y()) == (e.b.y() <= p.y())) continue;
    const double side = cross(Vector2d(e.b - e.a), Vector2d(p - e.a));
    if (e.a.y() <= p.y() ? side > 0 : side < 0) winding += e.a.y() <= p.y() ? 1 : -1;
  }
  return winding != 0;
}

void RegionIndex::crossings(const Vector2d& a, const Vector2d& b, std::vector<double>& at) const {
  if (edges_.empty()) return;
  const Eigen::AlignedBox2d box(a.cwiseMin(b), a.cwiseMax(b));
  if (!box.intersects(box_)) return;
  for (std::size_t s = strip_of(box.min().y()), last = strip_of(box.max().y()); s <= last; ++s) {
    effort_->spend(static_cast<double>(strips_[s].size()));
    for (const int i : strips_[s]) {
      const Vector2d along = b - a, edge = edges_[i].b - edges_[i].a, to = edges_[i].a - a;
      const double turn = cross(along, edge);
      if (turn == 0) continue;
      const double t = cross(to, edge) / turn, u = cross(to, along) / turn;
      if (t > 0 && t < 1 && u >= -1e-9 && u <= 1 + 1e-9) at.push_back(t);
    }
  }
}

}  // namespace impedraw

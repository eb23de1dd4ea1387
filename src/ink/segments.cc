#include "impedraw/ink/segments.h"

#include <nanoflann.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace impedraw {
namespace {

struct Samples {
  std::vector<Eigen::Vector3d> points;
  std::vector<int> segment;  // each sample's segment

  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using KdTree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Samples>, Samples, 3>;

// nanoflann result set: receives every sample nearer than worstDist() and may tighten that bound.
// Distances are squared.
template <typename Hear>
struct Listener {
  using DistanceType = double;
  using IndexType = std::size_t;
  double bound;
  Hear hear;  // (sample) → new bound
  bool addPoint(double, std::size_t sample) {
    bound = hear(sample);
    return true;
  }
  double worstDist() const { return bound; }
  bool full() const { return true; }
  std::size_t size() const { return 0; }
  void sort() {}
};

double square(double x) { return x * x; }

constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Interval = std::pair<double, double>;  // empty where first > second
constexpr Interval kNone{kInfinity, -kInfinity};

Interval clip(Interval i, double low, double high) {
  return {std::max(i.first, low), std::min(i.second, high)};
}

// t with a t² + 2 b t + c ≤ 0, a > 0.
Interval below_zero(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) return kNone;
  const double root = std::sqrt(discriminant);
  return {(-b - root) / a, (-b + root) / a};
}

// The line o + t u (u of unit length) inside the ball around c.
Interval in_ball(const Eigen::Vector3d& o, const Eigen::Vector3d& u, const Eigen::Vector3d& c,
                 double r) {
  const Eigen::Vector3d w = o - c;
  return below_zero(1.0, w.dot(u), w.squaredNorm() - r * r);
}

}  // namespace

double distance_to_segment(const Eigen::Vector3d& p, const Segment& s) {
  const Eigen::Vector3d d = s.b - s.a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - s.a).dot(d) / length2, 0.0, 1.0) : 0.0;
  return (p - s.a - t * d).norm();
}

struct Segments::Tree {
  std::vector<Segment> segments;
  Samples samples;
  double half_spacing;  // every point of a segment is within this distance of one of its samples
  std::unique_ptr<KdTree> index;

  template <typename Hear>
  void query(const Eigen::Vector3d& p, double reach, Hear hear) const {
    Listener<Hear> listener{square(reach), hear};
    index->findNeighbors(listener, p.data(), {});
  }
};

Segments::Segments(std::span<const std::vector<Eigen::Vector3d>> polylines, double spacing)
    : tree_(std::make_unique<Tree>()) {
  Tree& t = *tree_;
  t.half_spacing = 0.5 * spacing;
  for (const std::vector<Eigen::Vector3d>& line : polylines) {
    for (std::size_t i = 0; i + 1 < line.size() || (i == 0 && line.size() == 1); ++i) {
      const Segment s{line[i], line[std::min(i + 1, line.size() - 1)]};
      const int id = static_cast<int>(t.segments.size());
      t.segments.push_back(s);
      // One sample in the middle of each equal part: every point of the segment is within half a
      // part of a sample.
      const int parts = std::max(1, static_cast<int>(std::ceil((s.b - s.a).norm() / spacing)));
      for (int k = 0; k < parts; ++k) {
        t.samples.points.push_back(s.a + (k + 0.5) / parts * (s.b - s.a));
        t.samples.segment.push_back(id);
      }
    }
  }
  if (t.segments.empty()) return;
  t.index = std::make_unique<KdTree>(3, t.samples, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  t.index->buildIndex();
}

Segments::~Segments() = default;
Segments::Segments(Segments&&) noexcept = default;
Segments& Segments::operator=(Segments&&) noexcept = default;

bool Segments::empty() const { return tree_->segments.empty(); }

double Segments::distance(const Eigen::Vector3d& p) const {
  const Tree& t = *tree_;
  double best = std::numeric_limits<double>::infinity();
  if (empty() || !p.allFinite()) return best;
  // The nearest point has a sample of its own segment within half_spacing. Samples farther than
  // best + half_spacing can therefore be skipped.
  t.query(p, best, [&](std::size_t sample) {
    best = std::min(best, distance_to_segment(p, t.segments[t.samples.segment[sample]]));
    return square(best + t.half_spacing);
  });
  return best;
}

void Segments::visit_near(const Eigen::Vector3d& p, double reach,
                          const std::function<void(const Segment&)>& visit) const {
  const Tree& t = *tree_;
  if (empty()) return;
  const double bound = reach + t.half_spacing;
  t.query(p, bound * (1.0 + 1e-12), [&](std::size_t sample) {
    visit(t.segments[t.samples.segment[sample]]);
    return square(bound * (1.0 + 1e-12));
  });
}

// The points within reach of a segment form a capsule: two balls and the cylinder between them. A
// capsule is convex, so the result is one interval. It spans the intervals of the three parts.
std::pair<double, double> within_reach(const Segment& s, const Segment& ink, double reach) {
  const double length = (s.b - s.a).norm();
  const Eigen::Vector3d u = (s.b - s.a) / length;
  Interval all = in_ball(s.a, u, ink.a, reach);
  const auto join = [&](const Interval& i) {
    if (i.first <= i.second) all = {std::min(all.first, i.first), std::max(all.second, i.second)};
  };
  const Eigen::Vector3d axis = ink.b - ink.a;
  const double h = axis.norm();
  if (h > 0.0) {
    join(in_ball(s.a, u, ink.b, reach));
    const Eigen::Vector3d e = axis / h, w = s.a - ink.a;
    const double along = u.dot(e), start = w.dot(e);
    const Eigen::Vector3d u_across = u - along * e, w_across = w - start * e;
    const double a = u_across.squaredNorm(), c = w_across.squaredNorm() - reach * reach;
    Interval cylinder = a > 1e-24 ? below_zero(a, u_across.dot(w_across), c)
                                  : (c <= 0.0 ? Interval{-kInfinity, kInfinity} : kNone);
    if (std::abs(along) > 1e-12) {  // between the planes through the ends
      const double t0 = -start / along, t1 = (h - start) / along;
      cylinder = clip(cylinder, std::min(t0, t1), std::max(t0, t1));
    } else if (start < 0.0 || start > h) {
      cylinder = kNone;
    }
    join(cylinder);
  }
  return clip(all, 0.0, length);
}

Coverage cover(const std::vector<Eigen::Vector3d>& target, const Segments& ink, double reach) {
  Coverage result;
  double open = 0.0;  // length of the uncovered span that ends here
  bool any = false;   // something was covered
  double leading = 0.0;
  std::vector<Interval> near;
  const auto end_span = [&] {
    if (!any) leading = open;
    if (open > 0.0) result.uncovered_spans.push_back(open);
    open = 0.0;
    any = true;
  };
  for (std::size_t i = 0; i + 1 < target.size(); ++i) {
    const Segment s{target[i], target[i + 1]};
    const double length = (s.b - s.a).norm();
    if (length == 0.0) continue;
    result.length += length;
    near.clear();
    ink.visit_near(0.5 * (s.a + s.b), reach + 0.5 * length, [&](const Segment& piece) {
      const Interval part = within_reach(s, piece, reach);
      if (part.first <= part.second) near.push_back(part);
    });
    std::sort(near.begin(), near.end());
    double done = 0.0;  // length of the segment processed so far
    for (const Interval& part : near) {
      if (part.second < done) continue;
      if (part.first > done + 1e-12 * length) {
        open += part.first - done;
        done = part.first;
      }
      if (part.second > done) {
        end_span();
        result.covered += part.second - done;
        done = part.second;
      }
    }
    if (length - done > 1e-12 * length) open += length - done;
  }
  const bool closed =
      target.size() > 2 && (target.back() - target.front()).norm() <= 1e-9 * result.length;
  if (closed && any && leading > 0.0 && open > 0.0) {
    result.uncovered_spans.front() += open;
  } else if (open > 0.0) {
    result.uncovered_spans.push_back(open);
  }
  return result;
}

}  // namespace impedraw

#include "impedraw/ink/segments.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <nanoflann.hpp>

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

}  // namespace impedraw

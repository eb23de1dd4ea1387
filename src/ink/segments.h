// A set of straight segments in space (polylines, dots) with distance and proximity queries.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

struct Segment {
  Eigen::Vector3d a, b;  // a == b: a dot
};

double distance_to_segment(const Eigen::Vector3d& p, const Segment& s);

// Built once from polylines (consecutive points are joined, a single point is a dot), then const
// and safe to share between threads. Distances to the segments are exact; a kd-tree of samples at
// most `spacing` apart finds the candidates. Lengths are in the unit of the points.
class Segments {
 public:
  Segments(std::span<const std::vector<Eigen::Vector3d>> polylines, double spacing);
  ~Segments();
  Segments(Segments&&) noexcept;
  Segments& operator=(Segments&&) noexcept;

  bool empty() const;
  // Distance to the nearest segment; infinity if there is none.
  double distance(const Eigen::Vector3d& p) const;

  // Visits every segment within `reach` of p. May visit a segment twice, and some farther ones.
  void visit_near(const Eigen::Vector3d& p, double reach,
                  const std::function<void(const Segment&)>& visit) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

// Length of a target line that has ink nearby, and the spans that have none.

// In the unit of the points.
struct Coverage {
  double length = 0.0;   // of the target
  double covered = 0.0;  // length with ink within reach
  // Lengths, in order along the target. If the target's last point repeats the first, a span across
  // the joint counts as one.
  std::vector<double> uncovered_spans;
};

// Exact: a target point counts as covered if some point of an ink segment is within `reach` of it.
Coverage cover(const std::vector<Eigen::Vector3d>& target, const Segments& ink, double reach);

// Returns the part [first, second] of the segment s that is within `reach` of `ink`, as lengths
// from s.a; first > second: none.
std::pair<double, double> within_reach(const Segment& s, const Segment& ink, double reach);

}  // namespace impedraw

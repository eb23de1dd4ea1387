// A set of straight segments in space (polylines, dots) that answers: how far is this point, and
// which segments are near it?
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
// and safe to share between threads. Distances are exact, to the segments and not to their points:
// a kd-tree of samples at most `spacing` apart finds the candidates. Lengths in whatever unit the
// points have.
class Segments {
 public:
  Segments(std::span<const std::vector<Eigen::Vector3d>> polylines, double spacing);
  ~Segments();
  Segments(Segments&&) noexcept;
  Segments& operator=(Segments&&) noexcept;

  bool empty() const;
  double distance(
      const Eigen::Vector3d& p) const;  // to the nearest segment; infinite where there is none

  // Visits at least every segment that comes within `reach` of p; some may be visited twice, and
  // some further ones too.
  void visit_near(const Eigen::Vector3d& p, double reach,
                  const std::function<void(const Segment&)>& visit) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace impedraw

// The k points of a cloud nearest to a query: N(p), equation (18). A kd-tree (nanoflann) in double
// precision.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

constexpr int kMostNeighbours = 128;

// Order in which the points of one leaf, and leaves of one branch, lie side by side: for a cloud
// about to be searched a lot.
std::vector<int> tree_order(const std::vector<Eigen::Vector3d>& points);

// Refers to the points: they must outlive it, and stay as they are. Queries allocate nothing and
// may run in any number of threads.
class NeighbourTree {
 public:
  explicit NeighbourTree(const std::vector<Eigen::Vector3d>& points);
  ~NeighbourTree();

  // The k nearest points, nearest first, of those nearer than max_radius [m]: index and squared
  // distance [m²], room for k in both. Returns how many there are, at most k.
  int nearest(const Eigen::Vector3d& p, int k, double max_radius, int* index,
              double* squared) const noexcept;

  // The same points in any order but for the last, which is the furthest: faster by a third to a
  // half, since nothing is sorted on the way. reach2[i] is the squared distance of point i to its
  // own k-th neighbour: where the query's own will end, roughly. A query for which that guess is
  // too small falls back to nearest(). `closest`: the nearest point; −1 without any.
  int nearest_unordered(const Eigen::Vector3d& p, int k, double max_radius,
                        const std::vector<double>& reach2, int* index, double* squared,
                        int* closest) const noexcept;

 private:
  friend std::vector<int> tree_order(const std::vector<Eigen::Vector3d>& points);
  struct Tree;
  std::unique_ptr<const Tree> tree_;
};

}  // namespace impedraw

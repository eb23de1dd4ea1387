// The k points of a cloud nearest to a query: N(p), equation (18). Uses a kd-tree (nanoflann) in
// double precision.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

constexpr int kMostNeighbours = 128;

// Returns an order that keeps the points of a leaf, and the leaves of a branch, adjacent in memory.
// Use it for a cloud that is searched often.
std::vector<int> tree_order(const std::vector<Eigen::Vector3d>& points);

// Keeps a reference to the points. They must outlive the tree and must not change. Queries allocate
// nothing and may run in any number of threads.
class NeighbourTree {
 public:
  explicit NeighbourTree(const std::vector<Eigen::Vector3d>& points);
  ~NeighbourTree();

  // Finds the k nearest points within max_radius [m], nearest first, or in any order but for the
  // last one, the furthest. `index` and `squared` (squared distances [m²]) must have room for k
  // entries. Returns the number found. guess2: of the squared distance of the k-th; the points
  // within are gathered, which is twice as fast. If they are too few, or too many, all are sought.
  int nearest(const Eigen::Vector3d& p, int k, double max_radius, int* index, double* squared,
              double guess2 = 0.0, bool sorted = true) const noexcept;

  // The same points unordered. reach2[i] is the squared distance of point i to its own k-th
  // neighbour: the guess is that of a point nearby. closest: the nearest point; −1: there is none.
  int nearest_unordered(const Eigen::Vector3d& p, int k, double max_radius,
                        const std::vector<double>& reach2, int* index, double* squared,
                        int* closest) const noexcept;

  // True if at least so many points are nearer than the radius.
  bool has_within(const Eigen::Vector3d& p, double radius, int least) const noexcept;

 private:
  friend std::vector<int> tree_order(const std::vector<Eigen::Vector3d>& points);
  struct Tree;
  std::unique_ptr<const Tree> tree_;
};

}  // namespace impedraw

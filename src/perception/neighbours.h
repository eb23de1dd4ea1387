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

  // Finds the k nearest points within max_radius [m], nearest first. `index` and `squared` (squared
  // distances [m²]) must have room for k entries. Returns the number found.
  int nearest(const Eigen::Vector3d& p, int k, double max_radius, int* index,
              double* squared) const noexcept;

  // True if a point is nearer than the radius.
  bool any_within(const Eigen::Vector3d& p, double radius) const noexcept;
  // The same points unordered, except that the last one is the furthest. Faster by a third to a
  // half, because nothing is sorted. reach2[i] is the squared distance of point i to its own k-th
  // neighbour. It serves as a guess of the query's reach. If the guess is too small, the query
  // falls back to nearest(). `closest`: the nearest point; −1 if there is none.
  int nearest_unordered(const Eigen::Vector3d& p, int k, double max_radius,
                        const std::vector<double>& reach2, int* index, double* squared,
                        int* closest) const noexcept;

 private:
  friend std::vector<int> tree_order(const std::vector<Eigen::Vector3d>& points);
  struct Tree;
  std::unique_ptr<const Tree> tree_;
};

}  // namespace impedraw

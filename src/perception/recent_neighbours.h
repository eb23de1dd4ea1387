// Neighbours of a query that moves little from one call to the next, as a pen's tip does: the tree
// is searched once in a while for more points than are asked for, and the neighbours are found
// among them.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "impedraw/perception/neighbours.h"

namespace impedraw {

// The last neighbours in one tree and its points, for one thread.
class RecentNeighbours {
 public:
  // As NeighbourTree::nearest(). Allocates nothing.
  int nearest(const NeighbourTree& tree, const std::vector<Eigen::Vector3d>& points,
              const Eigen::Vector3d& p, int k, double max_radius, int* index,
              double* squared) noexcept;

 private:
  static constexpr double kSpare = 1.5;  // as many points are kept as are asked for, times this
  static constexpr int kMost = static_cast<int>(kSpare * kMostNeighbours);
  struct Item {
    double squared;  // distance from the last query [m²]
    int index, at;   // of the point in the cloud, and here
  };

  int among(const Eigen::Vector3d& p, double moved, int k, double max_radius, int* index,
            double* squared) noexcept;

  // All points within `reach` of `middle`: their places, and their order from the last query.
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
  double reach_ = 0.0;
  int n_ = 0;
  std::array<double, kMost> x_, y_, z_;
  std::array<Item, kMost> order_;
};

// A caller's memory from query to query of one SurfaceEstimator.
struct RecentSurface {
  RecentNeighbours widest;
  std::array<RecentNeighbours, 3> finer;  // of each detail level
};

}  // namespace impedraw

#include "impedraw/perception/neighbours.h"

#include <algorithm>
#include <limits>

#include <nanoflann.hpp>

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr int kLeaf = 12;  // points per leaf; for 50,000 points, 6 to 12 are equally fast
constexpr int kMostGathered = 3 * kMostNeighbours;  // capacity for points within the guessed reach
// factor on the squared reach: too small falls back, too large gathers points needlessly
constexpr double kGuessMargin = 1.2;

// Visits only the first leaf of the search, the query's own.
struct FirstLeaf {
  using DistanceType = double;
  using IndexType = int;
  int seen = 0;
  int closest = -1;
  double squared = std::numeric_limits<double>::max();

  bool addPoint(double d2, int i) {
    if (d2 < squared) {
      squared = d2;
      closest = i;
    }
    return ++seen < kLeaf / 2;
  }
  double worstDist() const { return std::numeric_limits<double>::max(); }
  bool full() const { return true; }
  void sort() {}
};

// The points within a radius, in any order, until they are `most`.
struct WithinReach {
  using DistanceType = double;
  using IndexType = int;
  double limit2;
  int most, n = 0;
  struct Item {
    double squared;
    int index;
    bool operator<(const Item& other) const { return squared < other.squared; }
  } items[kMostGathered];

  explicit WithinReach(double within2, int up_to = kMostGathered) : limit2(within2), most(up_to) {}
  bool addPoint(double d2, int i) {
    items[n++] = {d2, i};
    return n < most;
  }
  double worstDist() const { return limit2; }
  bool full() const { return true; }
  void sort() {}
};

// The nearest ones within a radius, nearest first. (The sets of nanoflann that know a radius differ
// between its versions.)
struct Nearest {
  using DistanceType = double;
  using IndexType = int;
  int capacity;
  int* index;
  double* squared;  // the last one holds the bound until the set is full
  int n = 0;

  bool addPoint(double d2, int i) {
    if (n == capacity && d2 >= worstDist()) return true;  // the tree asks once a leaf
    int at = n < capacity ? n++ : capacity - 1;
    for (; at > 0 && squared[at - 1] > d2; --at) {
      squared[at] = squared[at - 1];
      index[at] = index[at - 1];
    }
    squared[at] = d2;
    index[at] = i;
    return true;
  }
  double worstDist() const { return squared[capacity - 1]; }
  bool full() const { return n == capacity; }
  void sort() {}
};

// The points' order in the leaves, as the versions of nanoflann name it.
template <class Tree>
const auto& order_in(const Tree& tree) {
  if constexpr (requires { tree.vAcc_; })
    return tree.vAcc_;
  else
    return tree.vAcc;
}

}  // namespace

struct NeighbourTree::Tree {
  struct Points {
    const std::vector<Vector3d>* points;
    std::size_t kdtree_get_point_count() const { return points->size(); }
    double kdtree_get_pt(std::size_t i, std::size_t axis) const { return (*points)[i][axis]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };
  using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>,
                                                     Points, 3, int>;
  Points points;
  KdTree kd;
  explicit Tree(const std::vector<Vector3d>& given) : points{&given}, kd(3, points, {kLeaf}) {}
};

std::vector<int> tree_order(const std::vector<Vector3d>& points) {
  const NeighbourTree tree(points);
  const auto& order = order_in(tree.tree_->kd);
  return {order.begin(), order.end()};
}

NeighbourTree::NeighbourTree(const std::vector<Vector3d>& points)
    : tree_(std::make_unique<const Tree>(points)) {}
NeighbourTree::~NeighbourTree() = default;

int NeighbourTree::nearest(const Vector3d& p, int k, double max_radius, int* index, double* squared,
                           double guess2, bool sorted) const noexcept {
  if (guess2 > 0.0) {
    WithinReach found(std::min(max_radius * max_radius, kGuessMargin * guess2));
    tree_->kd.findNeighbors(found, p.data(), {});
    if (found.n >= k && found.n < kMostGathered) {
      if (sorted)
        std::partial_sort(found.items, found.items + k, found.items + found.n);
      else
        std::nth_element(found.items, found.items + k - 1, found.items + found.n);
      for (int i = 0; i < k; ++i) {
        index[i] = found.items[i].index;
        squared[i] = found.items[i].squared;
      }
      return k;
    }
  }
  Nearest found{k, index, squared};
  squared[k - 1] = max_radius * max_radius;
  tree_->kd.findNeighbors(found, p.data(), {});
  return found.n;
}

bool NeighbourTree::has_within(const Vector3d& p, double radius, int least) const noexcept {
  WithinReach found(radius * radius, std::min(least, kMostGathered));
  tree_->kd.findNeighbors(found, p.data(), {});
  return found.n >= least;
}

int NeighbourTree::nearest_unordered(const Vector3d& p, int k, double max_radius,
                                     const std::vector<double>& reach2, int* index, double* squared,
                                     int* closest) const noexcept {
  FirstLeaf leaf;
  tree_->kd.findNeighbors(leaf, p.data(), {});
  // For a query at height h above the surface, h² is added to all squared distances.
  const double guess2 = leaf.closest < 0 ? 0.0 : leaf.squared / kGuessMargin + reach2[leaf.closest];
  const int n = nearest(p, k, max_radius, index, squared, guess2, false);
  *closest = n > 0 ? index[std::min_element(squared, squared + n) - squared] : -1;
  return n;
}

}  // namespace impedraw

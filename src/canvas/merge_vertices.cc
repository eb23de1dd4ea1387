#include "impedraw/canvas/merge_vertices.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Geometry>

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr int kBits = 21;  // of a cell's number along each axis

// Kept vertices by grid cell: an open hash table of chains.
class Grid {
 public:
  Grid(const Eigen::AlignedBox3d& bounds, double tolerance, const std::vector<Vector3d>& kept)
      : origin_(bounds.min()), tolerance_(tolerance), kept_(kept), slots_(1024) {
    // Eight tolerances wide, so that most vertices search a single cell; wider if the cells would
    // exceed the key's range.
    cell_ = std::max({8 * tolerance, bounds.sizes().maxCoeff() / ((1 << kBits) - 8), 1e-300});
  }

  // The first kept vertex within the tolerance of p; −1: none.
  int find(const Vector3d& p) const {
    const Vector3d low = (p - origin_).array() - tolerance_,
                   high = (p - origin_).array() + tolerance_;
    const Eigen::Vector3i from = (low / cell_).array().floor().cast<int>(),
                          to = (high / cell_).array().floor().cast<int>();
    int best = -1;
    for (int x = from.x(); x <= to.x(); ++x)
      for (int y = from.y(); y <= to.y(); ++y)
        for (int z = from.z(); z <= to.z(); ++z)
          for (int v = slots_[slot(key(x, y, z))].head; v >= 0; v = next_[v]) {
            if ((best < 0 || v < best) && (kept_[v] - p).squaredNorm() <= tolerance_ * tolerance_)
              best = v;
          }
    return best;
  }

  // Adds the last vertex of `kept`.
  void add() {
    const int v = static_cast<int>(kept_.size()) - 1;
    const Eigen::Vector3i at = ((kept_[v] - origin_) / cell_).array().floor().cast<int>();
    if (2 * ++used_ > slots_.size()) grow();
    Slot& s = slots_[slot(key(at.x(), at.y(), at.z()))];
    s.key = key(at.x(), at.y(), at.z());
    next_.push_back(s.head);
    s.head = v;
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    int head = -1;
  };

  // Adds 1, since a vertex may search cells before the first.
  static std::uint64_t key(int x, int y, int z) {
    return (std::uint64_t(x + 1) << 2 * kBits) | (std::uint64_t(y + 1) << kBits) |
           std::uint64_t(z + 1);
  }
  std::size_t slot(std::uint64_t key) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = ((key * 0x9E3779B97F4A7C15u) >> 20) & mask;
    while (slots_[i].head >= 0 && slots_[i].key != key) i = (i + 1) & mask;
    return i;
  }
  void grow() {
    std::vector<Slot> old(4 * slots_.size());
    old.swap(slots_);
    for (const Slot& s : old) {
      if (s.head >= 0) slots_[slot(s.key)] = s;
    }
  }

  Vector3d origin_;
  double tolerance_, cell_;
  const std::vector<Vector3d>& kept_;
  std::vector<Slot> slots_;
  std::vector<int> next_;  // vertex in the same cell
  std::size_t used_ = 0;   // at least the occupied slots
};

}  // namespace

TriangleMesh merge_vertices(const TriangleMesh& mesh, double tolerance) {
  Eigen::AlignedBox3d bounds;
  for (const auto& t : mesh.triangles)
    for (const int v : t) bounds.extend(mesh.vertices[v]);
  TriangleMesh merged;
  merged.triangles.reserve(mesh.triangles.size());
  Grid grid(bounds, tolerance, merged.vertices);
  std::vector<int> now(mesh.vertices.size(), -1);
  for (const auto& t : mesh.triangles) {
    Eigen::Vector3i corners;
    for (int k = 0; k < 3; ++k) {
      int& v = now[t[k]];
      if (v < 0) v = grid.find(mesh.vertices[t[k]]);
      if (v < 0) {
        v = static_cast<int>(merged.vertices.size());
        merged.vertices.push_back(mesh.vertices[t[k]]);
        grid.add();
      }
      corners[k] = v;
    }
    merged.triangles.push_back(corners);
  }
  return merged;
}

}  // namespace impedraw

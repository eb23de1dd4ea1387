#include "impedraw/canvas/mesh_repair.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/Geometry>

namespace impedraw {
namespace {

struct Patch {  // triangles joined across edges that exactly two share
  std::vector<int> triangles;
  bool closed = true;
  Eigen::AlignedBox3d box;
  double volume = 0.0;  // [m³], < 0: inside out
};

// most closed patches tested for containing another; bounds the work
constexpr std::size_t kMostPatches = 64;

// Solid angle of a triangle as seen from p, as a share of the whole sphere, signed.
// Source: A. van Oosterom and J. Strackee, "The solid angle of a plane triangle", IEEE Trans.
// Biomed. Eng. 30(2), 1983.
double solid_angle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                   const Eigen::Vector3d& c) {
  const Eigen::Vector3d u = a - p, v = b - p, w = c - p;
  const double lu = u.norm(), lv = v.norm(), lw = w.norm();
  return std::atan2(u.dot(v.cross(w)),
                    lu * lv * lw + u.dot(v) * lw + v.dot(w) * lu + w.dot(u) * lv) /
         (2.0 * std::numbers::pi);
}

// Most of the inner patch's triangles, of a few of them, lie within the outer patch: the outer one
// goes round their middles once, whichever way it is wound.
bool contains(const TriangleMesh& mesh, const Winding& winding, const Patch& outer,
              const Patch& inner) {
  constexpr std::size_t kTried = 5;
  const std::size_t tried = std::min(kTried, inner.triangles.size());
  std::size_t within = 0;
  const auto corner = [&](int f, int i) -> const Eigen::Vector3d& {
    return mesh.vertices[mesh.triangles[f][i]];
  };
  for (std::size_t k = 0; k < tried; ++k) {
    const int at = inner.triangles[k * inner.triangles.size() / tried];
    const Eigen::Vector3d p = (corner(at, 0) + corner(at, 1) + corner(at, 2)) / 3.0;
    double turns = 0.0;
    for (const int f : outer.triangles)
      turns += (winding.wrong[f] ? -1.0 : 1.0) *
               solid_angle(p, corner(f, 0), corner(f, 1), corner(f, 2));
    within += std::abs(turns) > 0.5;
  }
  return 2 * within > tried;
}

}  // namespace

Winding find_winding(const TriangleMesh& mesh, const std::vector<HalfEdge>& edges) {
  const int n = static_cast<int>(mesh.triangles.size());
  Winding winding;
  winding.wrong.assign(n, false);
  std::vector<std::array<int, 3>> neighbour(n, {-1, -1, -1});
  std::vector<std::array<bool, 3>> against(n, {false, false, false});
  for_each_edge(edges, [&](const HalfEdge* first, const HalfEdge* last) {
    if (last - first != 2) return;
    for (int i = 0; i < 2; ++i) {
      neighbour[first[i].face][first[i].side] = first[1 - i].face;
      against[first[i].face][first[i].side] = first[0].forward == first[1].forward;
    }
  });

  Eigen::AlignedBox3d bounds;
  for (const auto& p : mesh.vertices) bounds.extend(p);
  std::vector<Patch> closed;
  std::vector<bool> seen(n, false), turned(n, false);
  for (int start = 0; start < n; ++start) {
    if (seen[start]) continue;
    Patch patch;
    patch.triangles = {start};
    seen[start] = true;
    for (std::size_t i = 0; i < patch.triangles.size(); ++i) {
      const int f = patch.triangles[i];
      for (int side = 0; side < 3; ++side) {
        const int g = neighbour[f][side];
        if (g < 0) {
          patch.closed = false;
          continue;
        }
        const bool desired = turned[f] != against[f][side];
        if (!seen[g]) {
          seen[g] = true;
          turned[g] = desired;
          patch.triangles.push_back(g);
        } else if (turned[g] != desired) {
          winding.twisted.push_back(std::max(f, g));
        }
      }
    }
    const auto count = std::count_if(patch.triangles.begin(), patch.triangles.end(),
                                     [&](int f) { return turned[f]; });
    const bool most = 2 * static_cast<std::size_t>(count) > patch.triangles.size();
    for (const int f : patch.triangles) winding.wrong[f] = turned[f] != most;
    if (!patch.closed) continue;
    for (const int f : patch.triangles) {
      Eigen::Matrix3d corner;
      for (int k = 0; k < 3; ++k) {
        corner.col(k) = mesh.vertices[mesh.triangles[f][k]] - bounds.center();
        patch.box.extend(mesh.vertices[mesh.triangles[f][k]]);
      }
      patch.volume += (winding.wrong[f] ? -1.0 : 1.0) * corner.determinant() / 6;
    }
    closed.push_back(std::move(patch));
  }

  std::vector<const Patch*> largest;
  for (const auto& patch : closed) largest.push_back(&patch);
  const auto larger = [](const Patch* a, const Patch* b) {
    return a->box.diagonal().norm() > b->box.diagonal().norm();
  };
  std::stable_sort(largest.begin(), largest.end(), larger);
  largest.resize(std::min(largest.size(), kMostPatches));
  for (const auto& patch : closed) {
    if (patch.volume >= 0.0) continue;
    const bool cavity = std::any_of(largest.begin(), largest.end(), [&](const Patch* other) {
      return other != &patch && other->box.contains(patch.box) &&
             other->box.diagonal().norm() > patch.box.diagonal().norm() &&
             contains(mesh, winding, *other, patch);
    });
    if (cavity) continue;
    for (const int f : patch.triangles) winding.wrong[f] = !winding.wrong[f];
  }
  std::sort(winding.twisted.begin(), winding.twisted.end());
  winding.twisted.erase(std::unique(winding.twisted.begin(), winding.twisted.end()),
                        winding.twisted.end());
  return winding;
}

namespace {

using Eigen::Vector3d;

constexpr int kBits = 21;  // of a cell's number along each axis

// Kept vertices by grid cell: an open hash table of chains.
class Grid {
 public:
  // `kept`: never more than `most`.
  Grid(const Eigen::AlignedBox3d& bounds, double tolerance, const std::vector<Vector3d>& kept,
       std::size_t most)
      : origin_(bounds.min()), tolerance_(tolerance), kept_(kept) {
    slots_.resize(std::bit_ceil(2 * most));
    // 32 tolerances wide, so that nine of ten vertices search the cell that was fetched for them
    // alone; wider if the cells would exceed the key's range.
    cell_ = std::max({32 * tolerance, bounds.sizes().maxCoeff() / ((1 << kBits) - 8), 1e-300});
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
          for (int v = slots_[slot(key(x, y, z))].last; v >= 0; v = next_[v]) {
            if ((best < 0 || v < best) && (kept_[v] - p).squaredNorm() <= tolerance_ * tolerance_)
              best = v;
          }
    return best;
  }

  // Adds the last vertex of `kept`.
  void add() {
    const int v = static_cast<int>(kept_.size()) - 1;
    const std::uint64_t at = key_of(kept_.back());
    Slot& cell = slots_[slot(at)];
    next_.push_back(cell.last);
    cell = {v, mark_of(at)};
  }

  // Fetches into the cache what find() and add() will read for p.
  void prefetch(const Vector3d& p) const { __builtin_prefetch(&slots_[first_slot(key_of(p))]); }

 private:
  // Adds 1, since a vertex may search cells before the first.
  static std::uint64_t key(int x, int y, int z) {
    return (std::uint64_t(x + 1) << 2 * kBits) | (std::uint64_t(y + 1) << kBits) |
           std::uint64_t(z + 1);
  }
  std::uint64_t key_of(const Vector3d& p) const {
    const Eigen::Vector3i at = ((p - origin_) / cell_).array().floor().cast<int>();
    return key(at.x(), at.y(), at.z());
  }
  static std::uint32_t mark_of(std::uint64_t key) {
    return static_cast<std::uint32_t>(key * 0x9E3779B97F4A7C15u);
  }
  std::size_t first_slot(std::uint64_t key) const {
    return ((key * 0x9E3779B97F4A7C15u) >> 20) & (slots_.size() - 1);
  }
  std::size_t slot(std::uint64_t key) const {
    std::size_t i = first_slot(key);
    while (slots_[i].last >= 0 &&
           (slots_[i].mark != mark_of(key) || key_of(kept_[slots_[i].last]) != key))
      i = (i + 1) & (slots_.size() - 1);
    return i;
  }

  Vector3d origin_;
  double tolerance_, cell_;
  const std::vector<Vector3d>& kept_;
  struct Slot {
    int last = -1;           // vertex of a cell
    std::uint32_t mark = 0;  // of the cell's key: another cell's vertex is hardly ever looked at
  };
  std::vector<Slot> slots_;
  std::vector<int> next_;  // vertex in the same cell
};

}  // namespace

TriangleMesh merge_vertices(const TriangleMesh& mesh, double tolerance) {
  Eigen::AlignedBox3d bounds;
  for (const auto& t : mesh.triangles)
    for (const int v : t) bounds.extend(mesh.vertices[v]);
  TriangleMesh merged;
  merged.triangles.reserve(mesh.triangles.size());
  Grid grid(bounds, tolerance, merged.vertices, mesh.vertices.size());
  std::vector<int> now(mesh.vertices.size(), -1);
  constexpr std::size_t kAhead = 6;  // triangles: a large mesh's slots are not in the cache
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3i& t = mesh.triangles[i];
    if (i + kAhead < mesh.triangles.size())
      for (const int v : mesh.triangles[i + kAhead]) grid.prefetch(mesh.vertices[v]);
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

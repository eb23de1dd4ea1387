#include "impedraw/canvas/mesh_topology.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <tuple>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

// For each vertex, the first one at the same position.
std::vector<int> merge_vertices(const std::vector<Eigen::Vector3d>& vertices) {
  constexpr std::size_t kAhead = 16;  // a large mesh's slots are not in the cache
  struct Slot {
    int first = -1;
    std::uint32_t mark = 0;  // of its hash: another position's vertex is hardly ever looked at
  };
  std::vector<int> first(vertices.size());
  std::vector<Slot> slots(std::bit_ceil(2 * vertices.size()));
  const auto hash_of = [&](std::size_t v) {
    std::uint64_t hash = 0;
    for (const double x : vertices[v]) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9E3779B97F4A7C15u;  // −0 is 0
      hash ^= hash >> 32;
    }
    return hash;
  };
  const auto slot_of = [&](std::uint64_t hash) { return hash & (slots.size() - 1); };
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    if (v + kAhead < vertices.size()) __builtin_prefetch(&slots[slot_of(hash_of(v + kAhead))]);
    const std::uint64_t hash = hash_of(v);
    const auto mark = static_cast<std::uint32_t>(hash >> 32);
    std::size_t i = slot_of(hash);
    while (slots[i].first >= 0 &&
           (slots[i].mark != mark || vertices[slots[i].first] != vertices[v]))
      i = (i + 1) & (slots.size() - 1);
    if (slots[i].first < 0) slots[i] = {static_cast<int>(v), mark};
    first[v] = slots[i].first;
  }
  return first;
}

void join_neighbours(MeshTopology& topology) {
  std::vector<Eigen::Vector3i> corners;
  corners.reserve(topology.faces.size());
  for (const auto& face : topology.faces)
    corners.emplace_back(face.vertex[0], face.vertex[1], face.vertex[2]);
  for_each_edge(half_edges(corners, static_cast<int>(topology.on_boundary.size())),
                [&](const HalfEdge* first, const HalfEdge* last) {
                  const HalfEdge& a = first[0];
                  if (last - first > 2) {
                    throw InputError(fmt::format(
                        "canvas mesh: {} triangles ({}, {}, {}, …) share the edge between vertices "
                        "{} and {}, at most two may",
                        last - first, a.face, first[1].face, first[2].face, a.low, a.high));
                  }
                  if (last - first == 1) {
                    topology.on_boundary[a.low] = true;
                    topology.on_boundary[a.high] = true;
                    return;
                  }
                  const HalfEdge& b = first[1];
                  if (a.forward == b.forward) {
                    throw InputError(
                        fmt::format("canvas mesh: triangles {} and {} are wound against each "
                                    "other, all must have the drawn-on side outward",
                                    a.face, b.face));
                  }
                  topology.faces[a.face].neighbour[a.side] = b.face;
                  topology.faces[b.face].neighbour[b.side] = a.face;
                });
}

// A thin triangle that is folded back between its neighbours, as simplified scans have them, leaves
// no sense to the normals beside it. Its normal becomes zero: it is passed over, as its neighbours
// cover it.
void pass_over_folds(MeshTopology& topology) {
  constexpr double kThin = 0.05;                   // height, as a share of the longest side
  constexpr double kHighest = 2e-4;                // [m]
  constexpr double kBack = -0.5, kParallel = 0.5;  // cosines of normals
  std::vector<MeshTopology::Face*> folds;
  for (MeshTopology::Face& face : topology.faces) {
    std::array<double, 3> side;
    for (int i = 0; i < 3; ++i) side[i] = (face.corner[(i + 1) % 3] - face.corner[i]).norm();
    const auto longest = std::max_element(side.begin(), side.end()) - side.begin(),
               shortest = std::min_element(side.begin(), side.end()) - side.begin();
    const double height =
        (face.corner[1] - face.corner[0]).cross(face.corner[2] - face.corner[0]).norm() /
        side[longest];
    if (!(height < std::min(kThin * side[longest], kHighest))) continue;
    const int a = face.neighbour[longest], b = face.neighbour[3 - longest - shortest];
    if (a < 0 || b < 0) continue;
    const Eigen::Vector3d &n_a = topology.faces[a].normal, &n_b = topology.faces[b].normal;
    if (face.normal.dot(n_a) < kBack && face.normal.dot(n_b) < kBack && n_a.dot(n_b) > kParallel)
      folds.push_back(&face);
  }
  for (MeshTopology::Face* fold : folds) fold->normal.setZero();
}

Eigen::Vector3d twice_area_vector(const MeshTopology::Face& face) {
  return (face.corner[1] - face.corner[0]).cross(face.corner[2] - face.corner[0]);
}

bool is_crease(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  static const double cosine = std::cos(MeshTopology::kCrease);
  return !a.isZero(0.0) && !b.isZero(0.0) && a.dot(b) < cosine;
}

// A face's share of the smooth normal of its corner i.
Eigen::Vector3d smooth_share(const MeshTopology::Face& face, int i) {
  if (face.normal.isZero(0.0)) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d u = face.corner[(i + 1) % 3] - face.corner[i];
  const Eigen::Vector3d v = face.corner[(i + 2) % 3] - face.corner[i];
  return twice_area_vector(face) / (u.squaredNorm() * v.squaredNorm());
}

// One smooth normal for each side of a vertex on a crease.
void split_at_creases(MeshTopology& topology) {
  bool any = false;
  for (MeshTopology::Face& face : topology.faces) {
    for (int i = 0; i < 3; ++i) {
      const int other = face.neighbour[i];
      face.crease[i] = other >= 0 && is_crease(face.normal, topology.faces[other].normal);
      if (face.crease[i])
        any = topology.on_crease[face.vertex[i]] = topology.on_crease[face.vertex[(i + 1) % 3]] =
            true;
    }
  }
  if (!any) return;
  DisjointSets sides(3 * topology.faces.size());  // corners of a vertex that no crease separates
  for (std::size_t f = 0; f < topology.faces.size(); ++f) {
    const MeshTopology::Face& face = topology.faces[f];
    for (int i = 0; i < 3; ++i) {
      const int other = face.neighbour[i];
      if (other < 0 || face.crease[i]) continue;
      for (int j = 0; j < 3; ++j)
        for (const int k : {i, (i + 1) % 3})
          if (topology.faces[other].vertex[j] == face.vertex[k])
            sides.join(3 * static_cast<int>(f) + k, 3 * other + j);
    }
  }
  std::vector<int> normal_of(3 * topology.faces.size(), -1);  // of each side
  for (std::size_t f = 0; f < topology.faces.size(); ++f) {
    MeshTopology::Face& face = topology.faces[f];
    for (int i = 0; i < 3; ++i) {
      if (!topology.on_crease[face.vertex[i]]) continue;
      const int corner = 3 * static_cast<int>(f) + i;
      int& normal = normal_of[sides.find(corner)];
      if (normal < 0) {
        normal = static_cast<int>(topology.smooth_normal.size());
        topology.smooth_normal.push_back(Eigen::Vector3d::Zero());
      }
      topology.smooth_normal[normal] += smooth_share(face, i);
      face.smooth[i] = normal;
    }
  }
}

}  // namespace

void require_valid(const TriangleMesh& mesh) {
  if (mesh.vertices.empty() || mesh.triangles.empty()) {
    throw InputError(
        fmt::format("canvas mesh: {} vertices and {} triangles, must have at least one triangle",
                    mesh.vertices.size(), mesh.triangles.size()));
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto& p = mesh.vertices[i];
    if (!p.allFinite()) {
      throw InputError(fmt::format("canvas mesh: vertex {} is ({}, {}, {}), must be finite", i,
                                   p.x(), p.y(), p.z()));
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const int v : mesh.triangles[i]) {
      if (v < 0 || v >= static_cast<int>(mesh.vertices.size())) {
        throw InputError(fmt::format("canvas mesh: triangle {} names vertex {}, must be in 0 … {}",
                                     i, v, mesh.vertices.size() - 1));
      }
    }
  }
}

MeshTopology make_topology(const TriangleMesh& mesh) {
  require_valid(mesh);
  const std::vector<int> first = merge_vertices(mesh.vertices);
  MeshTopology topology;
  topology.faces.resize(mesh.triangles.size());
  topology.smooth_normal.assign(mesh.vertices.size(), Eigen::Vector3d::Zero());
  topology.side_normal = topology.smooth_normal;
  topology.on_boundary.assign(mesh.vertices.size(), false);
  topology.on_crease = topology.on_boundary;
  bool any_area = false;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    auto& face = topology.faces[f];
    face.neighbour = {-1, -1, -1};
    double longest = 0.0;
    for (int i = 0; i < 3; ++i) {
      face.vertex[i] = first[mesh.triangles[f][i]];
      face.smooth[i] = face.vertex[i];
      face.corner[i] = mesh.vertices[mesh.triangles[f][i]];
    }
    for (int i = 0; i < 3; ++i)
      longest = std::max(longest, (face.corner[(i + 1) % 3] - face.corner[i]).norm());
    const Eigen::Vector3d cross = twice_area_vector(face);
    const double twice_area = cross.norm();
    const bool has_area = twice_area > 1e-12 * longest * longest && twice_area > 0.0;
    face.normal = has_area ? Eigen::Vector3d(cross / twice_area) : Eigen::Vector3d::Zero();
    any_area = any_area || has_area;
  }
  if (!any_area)
    throw InputError(
        fmt::format("canvas mesh: none of its {} triangles has an area", mesh.triangles.size()));
  join_neighbours(topology);
  pass_over_folds(topology);
  for (const MeshTopology::Face& face : topology.faces) {
    if (face.normal.isZero(0.0)) continue;
    const double twice_area = twice_area_vector(face).norm();
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d u = face.corner[(i + 1) % 3] - face.corner[i];
      const Eigen::Vector3d v = face.corner[(i + 2) % 3] - face.corner[i];
      topology.smooth_normal[face.vertex[i]] += smooth_share(face, i);
      topology.side_normal[face.vertex[i]] += std::atan2(twice_area, u.dot(v)) * face.normal;
    }
  }
  split_at_creases(topology);
  // A normal that cancels out (a fold) stays zero.
  for (auto& n : topology.smooth_normal) n.stableNormalize();
  for (auto& n : topology.side_normal) n.stableNormalize();
  return topology;
}

std::vector<HalfEdge> half_edges(const std::vector<Eigen::Vector3i>& triangles, int vertices) {
  const auto collapsed = [](const Eigen::Vector3i& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  };
  // Bucket by the lower vertex in one pass, as in a counting sort. Millions of edges are then
  // sorted a few at a time.
  std::vector<std::size_t> start(vertices + 1, 0);
  for (const auto& t : triangles) {
    if (collapsed(t)) continue;
    for (int side = 0; side < 3; ++side) ++start[std::min(t[side], t[(side + 1) % 3]) + 1];
  }
  for (int v = 0; v < vertices; ++v) start[v + 1] += start[v];
  std::vector<HalfEdge> edges(start[vertices]);
  std::vector<std::size_t> next(start.begin(), start.end() - 1);
  for (int f = 0; f < static_cast<int>(triangles.size()); ++f) {
    const auto& t = triangles[f];
    if (collapsed(t)) continue;
    for (int side = 0; side < 3; ++side) {
      const int a = t[side], b = t[(side + 1) % 3];
      edges[next[std::min(a, b)]++] = {std::min(a, b), std::max(a, b), f, side, a < b};
    }
  }
  const auto before = [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.high, a.face) < std::tie(b.high, b.face);
  };
  for (int v = 0; v < vertices; ++v)
    std::sort(edges.begin() + start[v], edges.begin() + start[v + 1], before);
  return edges;
}

}  // namespace impedraw

#include "impedraw/canvas/mesh_check.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/mesh_repair.h"
#include "impedraw/canvas/mesh_topology.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kWeld = 1e-6;                      // of the diagonal
constexpr double kApart = 1e-9;                     // vertices at one position are one [m]
constexpr double kLongest = 5.0, kShortest = 1e-3;  // [m], of the longest side

Eigen::AlignedBox3d bounds_of_triangles(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d bounds;
  for (const auto& t : mesh.triangles)
    for (const int v : t) bounds.extend(mesh.vertices[v]);
  return bounds;
}

bool collapsed(const Vector3i& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

// The mesh under repair, with the original number of each triangle.
struct Mending {
  CheckedMesh* checked;
  std::vector<int> number;

  TriangleMesh& mesh() { return checked->mesh; }

  // `of`: numbers of the triangles, ascending.
  void report(std::string kind, const std::vector<int>& of, bool repaired, const std::string& say) {
    if (of.empty()) return;
    std::string message =
        fmt::format("{}: {}, first triangle {}; {}", kind, of.size(), of.front(), say);
    std::replace(message.begin(), message.end(), '_', ' ');
    checked->faults.push_back(
        {std::move(kind), of.size(), of.front(), repaired, std::move(message)});
  }

  void drop(const std::vector<bool>& gone) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < number.size(); ++i) {
      if (gone[i]) continue;
      number[kept] = number[i];
      mesh().triangles[kept++] = mesh().triangles[i];
    }
    number.resize(kept);
    mesh().triangles.resize(kept);
  }

  void degenerate() {
    std::vector<int> faulty;
    std::vector<bool> thin(number.size(), false), gone(number.size(), false);
    for (std::size_t i = 0; i < number.size(); ++i) {
      gone[i] = collapsed(mesh().triangles[i]);
      thin[i] = !gone[i] && is_thin(*checked, mesh().triangles[i]);
      if (gone[i] || thin[i]) faulty.push_back(number[i]);
    }
    if (faulty.empty()) return;
    if (faulty.size() == number.size())
      throw InputError(fmt::format("none of its {} triangles has an area", number.size()));
    // A thin triangle is a seam between its neighbours, unless it lies on an edge that is joined
    // without it.
    for_each_edge(edges_of_mesh(), [&](const HalfEdge* first, const HalfEdge* last) {
      if (last - first <= 2) return;
      for (const HalfEdge* e = first; e < last; ++e) gone[e->face] = gone[e->face] || thin[e->face];
    });
    drop(gone);
    report("degenerate_triangle", faulty, true, "without area, left out or passed over");
  }

  // One of several triangles on the same vertices stays: the first of the winding that more of them
  // have, for two that are wound against each other cancel. None stays where they are a fold of a
  // surface, which closes without them.
  void duplicate() {
    const int n = static_cast<int>(number.size());
    const auto is_even = [](const Vector3i& t) {  // as a permutation of its ascending vertices
      return ((t[0] < t[1]) + (t[1] < t[2]) + (t[0] < t[2])) % 2 == 1;
    };
    std::vector<std::array<int, 4>> sorted(number.size());
    for (int i = 0; i < n; ++i) {
      const Vector3i& t = mesh().triangles[i];
      sorted[i] = {t[0], t[1], t[2], i};
      std::sort(sorted[i].begin(), sorted[i].begin() + 3);
    }
    std::sort(sorted.begin(), sorted.end());
    std::vector<bool> gone(number.size(), false);
    std::vector<int> cancelled;  // what stays of those that cancel
    for (std::size_t from = 0, to = 0; from < sorted.size(); from = to) {
      while (to < sorted.size() &&
             std::equal(sorted[to].begin(), sorted[to].begin() + 3, sorted[from].begin()))
        ++to;
      if (to == from + 1) continue;
      int even = 0;
      for (std::size_t i = from; i < to; ++i) even += is_even(mesh().triangles[sorted[i][3]]);
      const int odd = static_cast<int>(to - from) - even;
      int stays = -1;
      for (std::size_t i = from; i < to; ++i) {
        const int f = sorted[i][3];
        gone[f] = stays >= 0 || (even != odd && is_even(mesh().triangles[f]) != (even > odd));
        if (!gone[f]) stays = f;
      }
      if (even == odd) cancelled.push_back(stays);
    }
    if (std::find(gone.begin(), gone.end(), true) == gone.end()) return;
    leave_out_folds(cancelled, &gone);
    std::vector<int> faulty;
    for (int i = 0; i < n; ++i)
      if (gone[i]) faulty.push_back(number[i]);
    drop(gone);
    report("duplicate_triangle", faulty, true, "on the vertices of another one, left out");
  }

  // A fold is made of `cancelled` triangles that hang together, are few, and end at a surface that
  // two and two triangles close: a larger one may be a leaf, meant to be seen from both sides.
  void leave_out_folds(const std::vector<int>& cancelled, std::vector<bool>* gone) {
    constexpr int kFew = 8;
    if (cancelled.empty()) return;
    std::vector<bool> is_cancelled(number.size(), false), at_hole = is_cancelled,
                                                          at_surface = at_hole;
    for (const int f : cancelled) is_cancelled[f] = true;
    DisjointSets parts(number.size());
    for_each_edge(edges_of_mesh(), [&](const HalfEdge* first, const HalfEdge* last) {
      int part = -1, others = 0;
      for (const HalfEdge* e = first; e < last; ++e) {
        if (!is_cancelled[e->face]) {
          others += !(*gone)[e->face];
          continue;
        }
        if (part >= 0) parts.join(e->face, part);
        part = e->face;
      }
      if (part < 0) return;
      if (others % 2 == 1) at_hole[part] = true;  // if the part were left out
      if (others >= 2) at_surface[part] = true;
    });
    struct Part {
      int size = 0;
      bool at_hole = false, at_surface = false;
    };
    std::map<int, Part> of;
    for (const int f : cancelled) {
      Part& part = of[parts.find(f)];
      ++part.size;
      part.at_hole = part.at_hole || at_hole[f];
      part.at_surface = part.at_surface || at_surface[f];
    }
    for (const int f : cancelled) {
      const Part& part = of[parts.find(f)];
      if (part.at_surface && !part.at_hole && part.size <= kFew) (*gone)[f] = true;
    }
  }

  void edges_and_winding() {
    std::vector<HalfEdge> edges = edges_of_mesh();
    crowded_edges(&edges);
    Winding winding = find_winding(mesh(), edges);
    std::vector<int> twisted;
    // A scan may have a few; of a Möbius strip it is its shape.
    const std::size_t few = number.size() / 1000;
    while (!winding.twisted.empty() && twisted.size() + winding.twisted.size() <= few) {
      for (const int f : winding.twisted) {
        twisted.push_back(number[f]);
        loosen(f);
      }
      edges = edges_of_mesh();
      winding = find_winding(mesh(), edges);
    }
    checked->closed = true;
    for_each_edge(edges, [&](const HalfEdge* first, const HalfEdge* last) {
      checked->closed = checked->closed && last - first == 2;
    });
    std::sort(twisted.begin(), twisted.end());
    report("not_orientable", twisted, true, "wound against a neighbour either way, cut loose");
    for (int& f : winding.twisted) f = number[f];
    report("not_orientable", winding.twisted, false,
           "wound against a neighbour whichever way it is turned, all must have one side");
    if (!winding.twisted.empty()) return;
    std::vector<int> faulty;
    for (std::size_t i = 0; i < number.size(); ++i) {
      if (!winding.wrong[i]) continue;
      faulty.push_back(number[i]);
      std::swap(mesh().triangles[i][1], mesh().triangles[i][2]);
    }
    report("wrong_winding", faulty, true, "turned");
  }

  std::vector<HalfEdge> edges_of_mesh() {
    return half_edges(mesh().triangles, static_cast<int>(mesh().vertices.size()));
  }

  // `edges`: of the mesh, before and after.
  void crowded_edges(std::vector<HalfEdge>* edges) {
    std::vector<int> crowded;  // lowest triangle of each edge with too many
    int lowest = std::numeric_limits<int>::max();
    std::string at;
    for_each_edge(*edges, [&](const HalfEdge* first, const HalfEdge* last) {
      if (last - first <= 2) return;
      if (number[first->face] < lowest) {
        lowest = number[first->face];
        const Vector3d &p = mesh().vertices[first->low], &q = mesh().vertices[first->high];
        at = fmt::format(
            "its edge from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}) m is shared by {} "
            "triangles ({}, {}, {}, …), ",
            p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), last - first, number[first[0].face],
            number[first[1].face], number[first[2].face]);
      }
      crowded.push_back(number[first->face]);
    });
    if (crowded.empty()) return;
    std::sort(crowded.begin(), crowded.end());
    separate_sheets(*edges);
    const int loose = cut_loose(edges);
    report("non_manifold_edge", crowded, true,
           at + "two and two were joined" +
               (loose > 0 ? fmt::format(", {} triangles beside them cut loose", loose) : ""));
  }

  // Leaves two triangles on each edge: those that turn least. The others get vertices of their own.
  // Returns their number. `edges`: of the mesh, after.
  int cut_loose(std::vector<HalfEdge>* edges) {
    int loose = 0;
    for (std::vector<int> cut;; cut.clear()) {
      *edges = edges_of_mesh();
      for_each_edge(*edges, [&](const HalfEdge* first, const HalfEdge* last) {
        if (last - first <= 2) return;
        const std::vector<Pair> pairs = pairs_of(first, last);
        const Pair* const best = pairs.empty() ? nullptr : &pairs.front();
        for (const HalfEdge* e = first; e < last; ++e)
          if (!best || (e != best->a && e != best->b)) cut.push_back(e->face);
      });
      if (cut.empty()) return loose;
      std::sort(cut.begin(), cut.end());
      cut.erase(std::unique(cut.begin(), cut.end()), cut.end());
      loose += static_cast<int>(cut.size());
      for (const int face : cut) loosen(face);
    }
  }

  // Gives a triangle vertices of its own.
  void loosen(int face) {
    Vector3i& t = mesh().triangles[face];
    for (int i = 0; i < 3; ++i) t[i] = own_vertex(t, i);
  }

  // A new vertex at corner i of a triangle, a nanometre inside it.
  int own_vertex(const Vector3i& t, int i) {
    const Vector3d p = mesh().vertices[t[i]];
    const Vector3d inward =
        mesh().vertices[t[(i + 1) % 3]] + mesh().vertices[t[(i + 2) % 3]] - 2.0 * p;
    mesh().vertices.push_back(p + kApart * inward.normalized());
    return static_cast<int>(mesh().vertices.size()) - 1;
  }

  // Two triangles on one edge that are wound alike, and the cosine of the angle between them.
  struct Pair {
    const HalfEdge *a, *b;
    double turn;  // -1: flat
  };
  // The flattest first.
  std::vector<Pair> pairs_of(const HalfEdge* first, const HalfEdge* last) {
    const Vector3d &p = mesh().vertices[first->low], &q = mesh().vertices[first->high];
    const auto across = [&](const HalfEdge& e) {
      const Vector3d r = mesh().vertices[mesh().triangles[e.face][(e.side + 2) % 3]] - p,
                     along = (q - p).normalized();
      return Vector3d((r - along * along.dot(r)).normalized());
    };
    std::vector<Pair> pairs;
    for (const HalfEdge* a = first; a < last; ++a)
      for (const HalfEdge* b = a + 1; b < last; ++b)
        if (a->forward != b->forward) pairs.push_back({a, b, across(*a).dot(across(*b))});
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const Pair& x, const Pair& y) { return x.turn < y.turn; });
    return pairs;
  }

  // Gives each of the surfaces that touch along crowded edges its own vertices there.
  void separate_sheets(const std::vector<HalfEdge>& edges) {
    // Corners of one vertex that triangles beside each other join.
    const int corners = 3 * static_cast<int>(number.size());
    DisjointSets fans(static_cast<std::size_t>(corners));
    const auto corner = [](const HalfEdge& e, bool low) {
      return 3 * e.face + (e.forward == low ? e.side : (e.side + 1) % 3);
    };
    const auto join = [&](const HalfEdge& a, const HalfEdge& b) {
      for (const bool low : {true, false}) fans.join(corner(a, low), corner(b, low));
    };
    std::vector<bool> crowded(mesh().vertices.size(), false);
    for_each_edge(edges, [&](const HalfEdge* first, const HalfEdge* last) {
      if (last - first == 2) join(first[0], first[1]);
    });
    for_each_edge(edges, [&](const HalfEdge* first, const HalfEdge* last) {
      if (last - first <= 2) return;
      crowded[first->low] = crowded[first->high] = true;
      // First those that are joined elsewhere about this vertex.
      std::vector<Pair> pairs = pairs_of(first, last);
      std::stable_partition(pairs.begin(), pairs.end(), [&](const Pair& pair) {
        return fans.find(corner(*pair.a, true)) == fans.find(corner(*pair.b, true));
      });
      std::vector<bool> joined(static_cast<std::size_t>(last - first), false);
      for (const Pair& pair : pairs) {
        if (joined[pair.a - first] || joined[pair.b - first]) continue;
        joined[pair.a - first] = joined[pair.b - first] = true;
        join(*pair.a, *pair.b);
      }
    });
    std::map<std::pair<int, int>, int> own;  // of a vertex and a fan
    std::vector<bool> taken(mesh().vertices.size(), false);
    for (int c = 0; c < corners; ++c) {
      Vector3i& t = mesh().triangles[c / 3];
      const int v = t[c % 3];
      if (!crowded[v]) continue;
      const auto [at, is_new] = own.try_emplace({v, fans.find(c)}, v);
      if (is_new && taken[v]) {
        at->second = own_vertex(t, c % 3);
        crowded.push_back(false);
      }
      taken[v] = true;
      t[c % 3] = at->second;
    }
  }
};

void check_size(const Vector3d& size, CheckedMesh* checked) {
  const double longest = size.maxCoeff();
  if (longest <= kLongest && longest >= kShortest) return;
  const bool large = longest > kLongest;
  std::string message =
      fmt::format("it measures {:.4g} × {:.4g} × {:.4g} m, {}", size.x(), size.y(), size.z(),
                  large ? "more than 5 m: is its unit of length too long (mm taken for m)? If not, "
                          "cut out what the arm reaches"
                        : "less than 1 mm: is its unit of length too short (m taken for mm)?");
  checked->faults.push_back({large ? "too_large" : "too_small", 1, 0, false, std::move(message)});
}

// True if the mesh seems to have y up: an open one faces +y rather than +z; any stands on y = 0 and
// not on z = 0, or on a base at its lowest y that is wider than that at its lowest z.
bool seems_y_up(const TriangleMesh& mesh, const Eigen::AlignedBox3d& box) {
  Vector3d facing = Vector3d::Zero(), base = Vector3d::Zero();
  double area = 0.0;
  const Vector3d near = 0.02 * box.sizes();
  for (const Vector3i& t : mesh.triangles) {
    const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vector3d twice = (b - a).cross(c - a);
    facing += twice;
    area += twice.norm();
    for (int k = 1; k < 3; ++k)
      if (std::max({a[k], b[k], c[k]}) <= box.min()[k] + near[k]) base[k] += std::abs(twice[k]);
  }
  if (facing.norm() > 0.2 * area && facing.maxCoeff() == facing.cwiseAbs().maxCoeff())
    return facing.y() > 2.0 * facing.z() && facing.y() > facing.x();
  const auto stands = [&](int k) { return std::abs(box.min()[k]) <= near[k]; };
  if (stands(1) != stands(2)) return stands(1);
  return base.y() > 2.0 * base.z();
}

int count_components(const TriangleMesh& mesh) {
  DisjointSets parts(mesh.vertices.size());
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const auto& t : mesh.triangles) {
    for (const int v : t) {
      used[v] = true;
      parts.join(v, t[0]);
    }
  }
  int count = 0;
  for (int v = 0; v < static_cast<int>(used.size()); ++v) count += used[v] && parts.find(v) == v;
  return count;
}

}  // namespace

bool is_thin(const CheckedMesh& mesh, const Vector3i& t) {
  const auto& p = mesh.mesh.vertices;
  const double longest = std::max(
      {(p[t[1]] - p[t[0]]).norm(), (p[t[2]] - p[t[1]]).norm(), (p[t[0]] - p[t[2]]).norm()});
  return (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).norm() <= mesh.weld * longest;
}

CheckedMesh check_mesh(const TriangleMesh& mesh) {
  require_valid(mesh);
  CheckedMesh checked;
  checked.given_triangles = mesh.triangles.size();
  checked.bounds = bounds_of_triangles(mesh);
  checked.weld = kWeld * checked.bounds.diagonal().norm();
  checked.mesh = merge_vertices(mesh, checked.weld);
  check_size(checked.bounds.sizes(), &checked);
  Mending mending{&checked, std::vector<int>(mesh.triangles.size())};
  std::iota(mending.number.begin(), mending.number.end(), 0);
  mending.degenerate();
  mending.duplicate();
  mending.edges_and_winding();
  checked.components = count_components(checked.mesh);
  return checked;
}

CheckedMesh load_mesh(const std::filesystem::path& file, const MeshReading& reading) {
  std::vector<std::string> warnings;
  const TriangleMesh mesh = read_mesh(file, reading, &warnings);
  CheckedMesh checked;
  try {
    checked = check_mesh(mesh);
  } catch (const InputError& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  checked.warnings = std::move(warnings);
  const Eigen::AlignedBox3d& box = checked.bounds;
  if (!says_frame(file) && !reading.y_up && seems_y_up(checked.mesh, box)) {
    const double high = box.sizes().y();
    const bool long_unit = !reading.unit && box.sizes().maxCoeff() > kLongest;
    checked.warnings.push_back(
        fmt::format("stands upright as y; {:.3g} m high{}: canvas.mesh.up=y turns it",
                    long_unit ? 1e-3 * high : high, long_unit ? " if the unit is mm" : ""));
  }
  if (box.center().norm() > 10.0 * (1.0 + box.diagonal().norm()) && !reading.recentre) {
    checked.warnings.push_back(fmt::format(
        "lies {:.3g} m from its origin: canvas.mesh.recentre=true moves its middle there",
        box.center().norm()));
  }
  return checked;
}

void require_drawable(const CheckedMesh& mesh, const std::string& name) {
  for (const auto& fault : mesh.faults) {
    if (!fault.repaired) throw InputError(name + ": " + fault.message);
  }
}

}  // namespace impedraw

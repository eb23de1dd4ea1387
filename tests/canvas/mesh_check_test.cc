#include "impedraw/canvas/mesh_check.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include <gmock/gmock.h>

#include "impedraw/canvas/canvas.h"
#include "impedraw/canvas/mesh_facing.h"
#include "impedraw/canvas/mesh_repair.h"
#include "impedraw/common/errors.h"
#include "mesh_checks.h"
#include "mesh_files.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using ::testing::HasSubstr;

void add(TriangleMesh* m, const TriangleMesh& more, const Vector3d& shift) {
  const int offset = static_cast<int>(m->vertices.size());
  for (const auto& p : more.vertices) m->vertices.push_back(p + shift);
  for (const auto& t : more.triangles) m->triangles.push_back(t.array() + offset);
}

void turn(TriangleMesh* m) {
  for (auto& t : m->triangles) std::swap(t[1], t[2]);
}

double volume(const TriangleMesh& m) {
  double sum = 0;
  for (const auto& t : m.triangles)
    sum += m.vertices[t[0]].dot(m.vertices[t[1]].cross(m.vertices[t[2]])) / 6;
  return sum;
}

// The only fault, of that kind.
void expect_fault(const CheckedMesh& checked, const std::string& kind, std::size_t count, int first,
                  bool repaired) {
  ASSERT_EQ(checked.faults.size(), 1u);
  EXPECT_EQ(checked.faults[0].kind, kind);
  EXPECT_EQ(checked.faults[0].count, count);
  EXPECT_EQ(checked.faults[0].first, first);
  EXPECT_EQ(checked.faults[0].repaired, repaired);
}

// A sheet of n × n cells of 0.1 m.
TriangleMesh sheet(int n) {
  TriangleMesh m;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) m.vertices.push_back({0.1 * i, 0.1 * j, 0.0});
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int a = i * (n + 1) + j, b = a + n + 1;
      m.triangles.push_back({a, b, b + 1});
      m.triangles.push_back({a, b + 1, a + 1});
    }
  return m;
}

TEST(Weld, AgreesWithEveryPairCompared) {
  for (int seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    // A few places far apart, each with many vertices within the tolerance.
    const double tolerance = 1e-6;
    std::uniform_real_distribution<double> shift(-0.28 * tolerance, 0.28 * tolerance);
    std::uniform_int_distribution<int> place(0, 30);
    TriangleMesh m;
    std::vector<int> places;
    for (int i = 0; i < 600; ++i) {
      places.push_back(place(random));
      const Vector3d p(8 * tolerance * (places[i] % 4), 16 * tolerance * (places[i] / 4),
                       8 * tolerance * places[i]);
      m.vertices.push_back(p + Vector3d(shift(random), shift(random), shift(random)));
    }
    for (int i = 0; i + 2 < 600; ++i) m.triangles.push_back({i, i + 1, i + 2});
    const TriangleMesh merged = merge_vertices(m, tolerance);
    ASSERT_EQ(merged.triangles.size(), m.triangles.size());
    EXPECT_EQ(merged.vertices.size(), std::set<int>(places.begin(), places.end()).size());
    std::map<int, int> of;
    for (std::size_t i = 0; i < m.triangles.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const auto [at, fresh] = of.insert({places[m.triangles[i][k]], merged.triangles[i][k]});
        EXPECT_EQ(at->second, merged.triangles[i][k]);
      }
  }
}

TEST(MeshCheck, WeldsAtAMillionthOfTheDiagonal) {
  for (const double gap : {0.5e-6, 2e-6}) {  // of the diagonal, between two sheets side by side
    TriangleMesh m = sheet(1);
    add(&m, sheet(1), {0.1 + gap * std::hypot(0.2, 0.1), 0, 0});
    EXPECT_EQ(check_mesh(m).components, gap < 1e-6 ? 1 : 2) << gap;
  }
}

TEST(MeshCheck, LooseTrianglesOfABoxAreClosedAndOne) {
  const TriangleMesh b = box(0.1, 0.2, 0.3);
  TriangleMesh loose;
  for (const auto& t : b.triangles) {
    const int n = static_cast<int>(loose.vertices.size());
    for (const int v : t) loose.vertices.push_back(b.vertices[v]);
    loose.triangles.push_back({n, n + 1, n + 2});
  }
  add(&loose, b, {1, 0, 0});
  const CheckedMesh checked = check_mesh(loose);
  EXPECT_TRUE(checked.closed);
  EXPECT_EQ(checked.components, 2);
  EXPECT_TRUE(checked.faults.empty());
  loose.triangles.pop_back();
  EXPECT_FALSE(check_mesh(loose).closed);
}

TEST(MeshCheck, DegenerateTrianglesAreLeftOut) {
  TriangleMesh m = box(0.1, 0.2, 0.3);
  m.triangles.insert(m.triangles.begin() + 5, Vector3i(3, 3, 7));
  m.vertices.push_back(m.vertices[2] + Vector3d(1e-8, 0, 0));
  m.triangles.push_back({2, 8, 6});
  const CheckedMesh checked = check_mesh(m);
  expect_fault(checked, "degenerate_triangle", 2, 5, true);
  EXPECT_TRUE(checked.closed);
  EXPECT_EQ(checked.mesh.triangles.size(), 12u);
  EXPECT_EQ(checked.given_triangles, 14u);
  EXPECT_NO_THROW(Canvas{checked.mesh});
}

// Two triangles on one side of a line, one on the other, and a degenerate one that closes the seam:
// the seam is no edge of the surface.
TEST(MeshCheck, AThinTriangleBetweenNeighboursStaysAsASeam) {
  TriangleMesh m;
  m.vertices = {{0, 0, 0}, {0.2, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0.1, -0.1, 0}};
  m.triangles = {{0, 2, 3}, {2, 1, 3}, {0, 4, 1}, {0, 1, 2}};
  const CheckedMesh checked = check_mesh(m);
  expect_fault(checked, "degenerate_triangle", 1, 3, true);
  const Canvas canvas(checked.mesh);
  const SurfacePoint point = canvas.closest({0.07, 0.0, 0.01});
  EXPECT_FALSE(point.on_edge);
  EXPECT_NEAR(point.distance, 0.01, 1e-12);
  EXPECT_NEAR(canvas.closest({0.07, 0.0, -0.01}).distance, -0.01, 1e-12);
  EXPECT_LT((point.n_W - Vector3d::UnitZ()).norm(), 1e-12);
  // The same triangle is removed if the seam is closed without it.
  m.triangles = {{0, 1, 3}, {0, 4, 1}, {0, 1, 2}};
  EXPECT_EQ(check_mesh(m).mesh.triangles.size(), 2u);
}

TEST(MeshCheck, DuplicateTrianglesAreLeftOutWhicheverWayTheyAreWound) {
  TriangleMesh m = box(0.1, 0.2, 0.3);
  m.triangles.insert(m.triangles.begin() + 7, Vector3i(2, 1, 0));
  m.triangles.push_back({7, 5, 3});
  const CheckedMesh checked = check_mesh(m);
  expect_fault(checked, "duplicate_triangle", 2, 7, true);
  EXPECT_TRUE(checked.closed);
  EXPECT_EQ(checked.mesh.triangles.size(), 12u);
  EXPECT_NEAR(volume(checked.mesh), 0.006, 1e-15);
}

TEST(MeshCheck, TrianglesWoundTheWrongWayAreTurned) {
  for (int seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    TriangleMesh m = sheet(6);
    std::set<int> turned;
    std::uniform_int_distribution<int> pick(0, static_cast<int>(m.triangles.size()) - 1);
    while (turned.size() < 20) turned.insert(pick(random));
    for (const int i : turned) std::swap(m.triangles[i][0], m.triangles[i][1]);
    const CheckedMesh checked = check_mesh(m);
    expect_fault(checked, "wrong_winding", 20, *turned.begin(), true);
    for (const auto& t : checked.mesh.triangles) EXPECT_GT(cross(checked.mesh, t).z(), 0.0);
    EXPECT_NO_THROW(Canvas{checked.mesh});
  }
}

TEST(MeshCheck, AClosedMeshInsideOutIsTurnedButNotTheCavityOfAnother) {
  TriangleMesh m = box(0.1, 0.2, 0.3);
  turn(&m);
  CheckedMesh checked = check_mesh(m);
  expect_fault(checked, "wrong_winding", 12, 0, true);
  EXPECT_NEAR(volume(checked.mesh), 0.006, 1e-15);

  TriangleMesh cavity = box(0.02, 0.02, 0.02), hollow = box(0.1, 0.2, 0.3);
  turn(&cavity);
  add(&hollow, cavity, {0.05, 0.05, 0.05});
  checked = check_mesh(hollow);
  EXPECT_TRUE(checked.faults.empty());
  EXPECT_NEAR(volume(checked.mesh), 0.006 - 8e-6, 1e-15);
}

TEST(MeshCheck, ABoxInsideOutBesideALargerBodyIsNoCavityOfIt) {
  TriangleMesh body;  // its bounding box is larger than it
  body.vertices = {{0.0, 0.0, 0.0}, {0.3, 0.0, 0.0}, {0.0, 0.3, 0.0}, {0.0, 0.0, 0.3}};
  body.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  TriangleMesh inside_out = box(0.02, 0.02, 0.02);
  turn(&inside_out);
  for (const double at : {0.02, 0.2}) {
    TriangleMesh both = body;
    add(&both, inside_out, Vector3d::Constant(at));
    const bool is_cavity = at < 0.1;
    EXPECT_NEAR(volume(check_mesh(both).mesh), 0.0045 + (is_cavity ? -8e-6 : 8e-6), 1e-12);
  }
}

TEST(MeshCheck, AFinOnASheetIsNamedAndSeparated) {
  TriangleMesh m = sheet(
      // the fin stands on the inner edge from vertex 1 to vertex 4, of triangles 1 and 2 among
      // others
      2);
  m.vertices.push_back({0.05, 0.1, 0.1});
  m.triangles.push_back({1, 4, 9});
  std::vector<int> on_edge;
  for (int i = 0; i < static_cast<int>(m.triangles.size()); ++i) {
    if ((m.triangles[i].array() == 1).any() && (m.triangles[i].array() == 4).any())
      on_edge.push_back(i);
  }
  ASSERT_EQ(on_edge.size(), 3u);
  const CheckedMesh checked = check_mesh(m);
  expect_fault(checked, "non_manifold_edge", 1, on_edge[0], true);
  EXPECT_FALSE(checked.closed);
  EXPECT_THAT(checked.faults[0].message,
              HasSubstr(fmt::format("({}, {}, {}, …)", on_edge[0], on_edge[1], on_edge[2])));
  EXPECT_EQ(checked.components, 2) << "the sheet goes on beneath the fin";
  EXPECT_EQ(checked.mesh.triangles.size(), m.triangles.size());
  // Triangles beside each other across the fin's foot have one normal, that of the sheet.
  const Canvas canvas(checked.mesh);
  const auto hit = canvas.ray({0.101, 0.05, 1.0}, -Eigen::Vector3d::UnitZ());
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->n_W.z(), 1.0, 1e-9);
}

// Four triangles share the edge where they touch.
TEST(MeshCheck, BoxesThatTouchAlongAnEdgeStayClosed) {
  for (const bool turned : {false, true}) {
    TriangleMesh both = box(0.1, 0.2, 0.3), other = box(0.1, 0.2, 0.3);
    if (turned) turn(&other);
    add(&both, other, {0.1, 0.2, 0.0});
    const CheckedMesh checked = check_mesh(both);
    EXPECT_TRUE(checked.closed || turned);
    EXPECT_EQ(checked.faults[0].kind, "non_manifold_edge");
    EXPECT_NO_THROW(require_drawable(checked, "boxes.obj"));
    if (!turned) {
      EXPECT_NEAR(volume(checked.mesh), 0.012, 1e-9);
    }
    const Canvas canvas(checked.mesh);
    const auto near = canvas.closest({0.15, 0.3, 0.31}, 0.1);
    ASSERT_TRUE(near);
    EXPECT_NEAR(near->distance, 0.01, 1e-9);
  }
}

// A simplified scan had 1,250 of them, which broke its surface into a thousand patches, some wound
// inside out: the pen was thrown by 38 N.
TEST(MeshCheck, AFoldOfASurfaceIsLeftOut) {
  TriangleMesh m = box(0.1, 0.2, 0.3);
  const std::size_t whole = m.triangles.size();
  const Vector3i t = m.triangles[0];
  m.vertices.push_back({0.05, 0.1, 0.35});
  const int out = static_cast<int>(m.vertices.size()) - 1;
  m.triangles.push_back({t[0], t[1], out});
  m.triangles.push_back({t[1], t[0], out});
  const CheckedMesh checked = check_mesh(m);
  expect_fault(checked, "duplicate_triangle", 2, static_cast<int>(whole), true);
  EXPECT_EQ(checked.faults.size(), 1u);
  EXPECT_TRUE(checked.closed);
  EXPECT_NEAR(volume(checked.mesh), 0.006, 1e-12);
}

TEST(MeshCheck, ASheetWithTwoSidesStays) {
  TriangleMesh m = sheet(3);
  const std::size_t one_side = m.triangles.size();
  TriangleMesh back = m;
  turn(&back);
  m.triangles.insert(m.triangles.end(), back.triangles.begin(), back.triangles.end());
  EXPECT_EQ(check_mesh(m).mesh.triangles.size(), one_side);
}

// A scan of a bust, open below and wound inside out: the pen went through it.
TEST(MeshFacing, OpenPartsSeenFromBehindAreTurned) {
  TriangleMesh open = box(0.1, 0.2, 0.3);
  std::erase_if(open.triangles, [&](const Vector3i& t) {
    return open.vertices[t[0]].z() + open.vertices[t[1]].z() + open.vertices[t[2]].z() == 0.0;
  });
  ASSERT_EQ(open.triangles.size(), 10u);
  const auto turned = [](const TriangleMesh& given, TriangleMesh* result) {
    *result = given;
    return turn_parts_seen_from_behind(result, Vector3d::UnitZ());
  };
  TriangleMesh back = open, result;
  turn(&back);
  EXPECT_EQ(turned(open, &result), 0);
  EXPECT_EQ(turned(back, &result), 10);
  const auto up = [](const TriangleMesh& m) {
    return Canvas(m).closest(Vector3d(0.05, 0.1, 0.31)).n_W.z();
  };
  EXPECT_EQ(up(back), -1.0);
  EXPECT_EQ(up(result), 1.0);
  TriangleMesh two = open;  // each part by itself, a closed one as it is
  add(&two, back, {0.3, 0.0, 0.0});
  TriangleMesh closed = box(0.1, 0.1, 0.1);
  turn(&closed);
  add(&two, closed, {0.6, 0.0, 0.0});
  EXPECT_EQ(turned(two, &result), 10);
}

// On a simplified scan the pen was taken to be below a triangle of 0.06 mm² that is folded back
// between its neighbours, and thrown by 100 N.
TEST(MeshCheck, AThinTriangleFoldedBackIsPassedOver) {
  constexpr int kSeed = 2;
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> about(-1.0, 1.0);
  for (int k = 0; k < 200; ++k) {
    SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", mesh " << k);
    const double off = 5e-5 * about(rng);  // of the middle vertex from the diagonal [m]
    TriangleMesh m;
    m.vertices = {{0.0, 0.0, 0.0},
                  {0.01, 0.0, 0.004 * about(rng)},
                  {0.01, 0.01, 0.0},
                  {0.0, 0.01, 0.004 * about(rng)},
                  {0.005 - off, 0.005 + off, 2e-5 * about(rng)}};
    m.triangles = {{0, 1, 2}, {0, 2, 4}, {0, 4, 3}, {4, 2, 3}};
    const Canvas canvas(check_mesh(m).mesh);
    for (int i = 0; i < 50; ++i) {
      const double along = 0.005 + 0.003 * about(rng), beside = 5e-4 * about(rng);
      const auto near = canvas.closest({along + beside, along - beside, 1.5e-3});
      EXPECT_GT(near.distance, 5e-4) << along << ", " << beside;
      EXPECT_GT(near.n_W.z(), 0.5);
    }
  }
}

TriangleMesh moebius_strip() {
  TriangleMesh m;
  constexpr int n = 20;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * i / n;
    for (const double w : {-0.05, 0.05}) {
      const double r = 0.2 + w * std::cos(a / 2);
      m.vertices.push_back({r * std::cos(a), r * std::sin(a), w * std::sin(a / 2)});
    }
  }
  for (int i = 0; i < n; ++i) {
    const int a = 2 * i, b = a + 1;
    const int c = i + 1 < n ? a + 2 : 1, d = i + 1 < n ? a + 3 : 0;
    m.triangles.push_back({a, c, b});
    m.triangles.push_back({b, c, d});
  }
  return m;
}

TEST(MeshCheck, AMoebiusStripHasNoSide) {
  const CheckedMesh checked = check_mesh(moebius_strip());
  ASSERT_EQ(checked.faults.size(), 1u);
  EXPECT_EQ(checked.faults[0].kind, "not_orientable");
  EXPECT_THROW(require_drawable(checked, "strip"), InputError);
}

// A scan of a dragon had two such triangles of 48,000, and was refused.
TEST(MeshCheck, AFewTwistedTrianglesOfALargeMeshAreCutLoose) {
  TriangleMesh m;
  add(&m, sheet(40), {0.0, 0.0, 0.3});
  add(&m, moebius_strip(), Vector3d::Zero());
  const CheckedMesh checked = check_mesh(m);
  ASSERT_FALSE(checked.faults.empty());
  EXPECT_EQ(checked.faults[0].kind, "not_orientable");
  EXPECT_TRUE(checked.faults[0].repaired);
  EXPECT_NO_THROW(require_drawable(checked, "both"));
  const Canvas canvas(checked.mesh);
  const auto hit = canvas.ray({0.2, 0.2, 1.0}, {0.0, 0.0, -1.0});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->p_W.z(), 0.3, 1e-9);
}

// Random triangles on few vertices: edges with up to eight triangles, of one body.
TEST(MeshCheck, EveryCrowdedEdgeIsSeparated) {
  constexpr int kSeed = 3;
  std::mt19937 rng(kSeed);
  std::uniform_real_distribution<double> place(-0.1, 0.1);
  std::uniform_int_distribution<int> some(0, 9);
  int loose = 0;
  for (int k = 0; k < 200; ++k) {
    SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", mesh " << k);
    TriangleMesh m;
    for (int i = 0; i < 10; ++i) m.vertices.push_back({place(rng), place(rng), place(rng)});
    for (int i = 0; i < 40; ++i) {
      const Vector3i t(some(rng), some(rng), some(rng));
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) m.triangles.push_back(t);
    }
    const CheckedMesh checked = check_mesh(m);
    std::map<std::pair<int, int>, int> on_edge;
    for (const Vector3i& t : checked.mesh.triangles)
      for (int i = 0; i < 3; ++i) ++on_edge[std::minmax(t[i], t[(i + 1) % 3])];
    for (const auto& [edge, triangles] : on_edge) EXPECT_LE(triangles, 2);
    for (const MeshFault& fault : checked.faults)
      loose += fault.message.find("cut loose") != std::string::npos;
  }
  EXPECT_GT(loose, 10) << "or the meshes are too simple";
}

TEST(MeshCheck, ASizeOfAWrongUnitIsSaid) {
  expect_fault(check_mesh(box(150, 150, 200)), "too_large", 1, 0, false);
  expect_fault(check_mesh(box(1.5e-4, 1.5e-4, 2e-4)), "too_small", 1, 0, false);
  EXPECT_TRUE(check_mesh(box(4.9, 3, 2)).faults.empty());
  EXPECT_THAT(check_mesh(box(150, 150, 200)).faults[0].message, HasSubstr("150 × 150 × 200 m"));
}

TEST(MeshCheck, RefusesWhatHasNoArea) {
  TriangleMesh line;
  line.vertices = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}};
  line.triangles = {{0, 1, 2}};
  EXPECT_THROW(check_mesh(line), InputError);
  EXPECT_THROW(check_mesh({}), InputError);
  line.triangles = {{0, 1, 3}};
  EXPECT_THROW(check_mesh(line), InputError);
  TriangleMesh point;
  point.vertices = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  point.triangles = {{0, 1, 2}};
  EXPECT_THROW(check_mesh(point), InputError);
}

}  // namespace
}  // namespace impedraw

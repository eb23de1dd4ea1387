#include "impedraw/page/page_json.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "impedraw/common/seeded_normals.h"

namespace impedraw {
namespace {

// A bowl z = x² + y² over a square of n×n cells, 0.4 m wide.
void make_bowl(int n, std::vector<Eigen::Vector3d>* vertices,
               std::vector<Eigen::Vector3i>* triangles) {
  for (int i = 0; i <= n; ++i)
    for (int k = 0; k <= n; ++k) {
      const double x = 0.4 * i / n - 0.2, y = 0.4 * k / n - 0.2;
      vertices->push_back({x, y, x * x + y * y});
    }
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k) {
      const int a = i * (n + 1) + k, b = a + n + 1;
      triangles->push_back({a, b, a + 1});
      triangles->push_back({a + 1, b, b + 1});
    }
}

TEST(PageMesh, ALargeMeshIsThinnedWithoutLeavingTheSurface) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  make_bowl(200, &vertices, &triangles);
  const PageMesh mesh = page_mesh(vertices, triangles, 5000, 1e-4);
  EXPECT_LE(mesh.triangles.size(), 5000u);
  EXPECT_GT(mesh.triangles.size(), 500u);
  double worst = 0.0, area = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d p =
        (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
    worst = std::max(worst, std::abs(p.z() - p.head<2>().squaredNorm()));
    const Eigen::Vector3d n = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                                  .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    EXPECT_GT(n.dot(Eigen::Vector3d(-2 * p.x(), -2 * p.y(), 1)), 0.0) << "winding is kept";
    area += 0.5 * n.z();
  }
  EXPECT_NEAR(area, 0.16, 1e-4) << "from above: no holes, nothing twice";
  EXPECT_LT(worst, 0.2e-3);
}

TEST(PageMesh, TwoMillionTrianglesBecomeAsManyAsAPageShows) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  make_bowl(1000, &vertices, &triangles);
  ASSERT_EQ(triangles.size(), 2'000'000u);
  constexpr std::size_t kMost = 16000;
  const PageMesh mesh = page_mesh(vertices, triangles, kMost, 1e-4);
  EXPECT_LE(mesh.triangles.size(), kMost + kMost / 4);
  EXPECT_GT(mesh.triangles.size(), kMost / 4);
  double worst = 0.0, area = 0.0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
    const Eigen::Vector3d p = (a + b + c) / 3.0;
    worst = std::max(worst, std::abs(p.z() - p.head<2>().squaredNorm()));
    area += 0.5 * (b - a).cross(c - a).z();
  }
  EXPECT_NEAR(area, 0.16, 1e-4);
  EXPECT_LT(worst, 0.2e-3);
}

// How many edges have one triangle alone.
long border_edges(const std::vector<Eigen::Vector3i>& triangles) {
  std::map<std::pair<int, int>, int> sides;
  for (const Eigen::Vector3i& t : triangles)
    for (int k = 0; k < 3; ++k) ++sides[std::minmax({t[k], t[(k + 1) % 3]})];
  return std::count_if(sides.begin(), sides.end(), [](const auto& s) { return s.second == 1; });
}

TEST(PageMesh, ThinningMakesNoHoles) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  make_bowl(200, &vertices, &triangles);
  // Uneven, so that collapsed edges fold.
  SeededNormals normals(7);
  for (Eigen::Vector3d& v : vertices)
    if (v.head<2>().cwiseAbs().maxCoeff() < 0.1999)
      v.head<2>() += 4e-4 * Eigen::Vector2d(normals.next(), normals.next());
  const PageMesh mesh = page_mesh(vertices, triangles, 5000, 1e-4);
  EXPECT_EQ(border_edges(mesh.triangles), 800);
}

TEST(PageMesh, CoarseTrianglesStayWithinTheirTolerance) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  make_bowl(100, &vertices, &triangles);
  const PageMesh mesh = page_mesh(vertices, triangles, 100000, 1e-4);
  const std::vector<Eigen::Vector3i>& coarse = mesh.coarse;
  EXPECT_LT(3 * coarse.size(), mesh.triangles.size());
  EXPECT_GT(coarse.size(), 500u);
  EXPECT_EQ(border_edges(coarse), 400);
  double worst = 0.0, area = 0.0;
  for (const Eigen::Vector3i& t : coarse) {
    const Eigen::Vector3d a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
    const Eigen::Vector3d p = (a + b + c) / 3.0;
    worst = std::max(worst, std::abs(p.z() - p.head<2>().squaredNorm()));
    area += 0.5 * (b - a).cross(c - a).z();
  }
  EXPECT_NEAR(area, 0.16, 1e-3);
  EXPECT_LT(worst, 2e-4) << "the quadric's measure, not the largest distance";
  EXPECT_TRUE(page_mesh(vertices, triangles, 100000, 1e-9).coarse.empty()) << "nothing to save";
  EXPECT_TRUE(page_mesh({}, {}, 10, 1e-4).coarse.empty());
}

TEST(PageMesh, ASmallMeshStaysWhole) {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  make_bowl(5, &vertices, &triangles);
  vertices.push_back({9, 9, 9});  // unused
  const PageMesh mesh = page_mesh(vertices, triangles, 5000, 1e-4);
  EXPECT_EQ(mesh.triangles.size(), 50u);
  EXPECT_EQ(mesh.vertices.size(), 36u);
  EXPECT_EQ(mesh.error, 0.0);
  EXPECT_TRUE(page_mesh({}, {}, 10, 1e-4).triangles.empty());
}

}  // namespace
}  // namespace impedraw

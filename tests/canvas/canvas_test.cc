#include "impedraw/canvas/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/canvas/built_in.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

// Closest point of a triangle by another method: its projection onto the plane if that lies inside,
// else the closest point on the three sides.
double brute_distance(const TriangleMesh& m, const Vector3d& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& t : m.triangles) {
    const std::array<Vector3d, 3> v{m.vertices[t[0]], m.vertices[t[1]], m.vertices[t[2]]};
    const Vector3d n = (v[1] - v[0]).cross(v[2] - v[0]).normalized();
    const Vector3d foot = p - n * n.dot(p - v[0]);
    bool inside = true;
    for (int i = 0; i < 3; ++i)
      inside = inside && n.dot((v[(i + 1) % 3] - v[i]).cross(foot - v[i])) >= 0;
    double d = (p - foot).norm();
    if (!inside) {
      d = std::numeric_limits<double>::infinity();
      for (int i = 0; i < 3; ++i) {
        const Vector3d u = v[(i + 1) % 3] - v[i];
        d = std::min(
            d, (v[i] + u * std::clamp(u.dot(p - v[i]) / u.squaredNorm(), 0.0, 1.0) - p).norm());
      }
    }
    best = std::min(best, d);
  }
  return best;
}

TriangleMesh tetrahedron() {  // closed, with sharp corners, wound outward
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.2}},
          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

// A roof along x, whose sides of 1 m lean by `lean` [rad] and face up. Its ridge is y = 0.
TriangleMesh roof(double lean) {
  const double y = std::cos(lean), z = -std::sin(lean);
  return {{{0, -y, z}, {1, -y, z}, {0, 0, 0}, {1, 0, 0}, {0, y, z}, {1, y, z}},
          {{0, 1, 3}, {0, 3, 2}, {2, 3, 5}, {2, 5, 4}}};
}

TEST(Canvas, ZeroOfEitherSignIsOnePlace) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 0.1, 0}, {-0.1, 0, 0}, {-0.0, 0, 0}, {-0.0, 0.1, 0}, {0.1, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 5, 4}};
  EXPECT_FALSE(Canvas(mesh).closest({0, 0.05, 0.01}).on_edge);
}

// Beside a sharp edge a flat face's normal is its own; over the edge it is the way to the point.
TEST(Canvas, NormalsAreNotSmoothedAcrossCreases) {
  for (const double lean : {0.5, 0.9}) {
    SCOPED_TRACE(lean);
    const Canvas canvas(roof(lean));
    const Vector3d side(0, std::sin(lean), std::cos(lean)),
        down(0, std::cos(lean), -std::sin(lean));
    for (const double off : {1e-3, 0.1, 0.5}) {
      const Vector3d p = Vector3d(0.5, 0, 0) + off * down + 1e-3 * side;
      EXPECT_LT((canvas.closest(p).n_W - side).norm(), 1e-12);
      const auto hit = canvas.ray(p, -side);
      ASSERT_TRUE(hit);
      EXPECT_LT((hit->n_W - side).norm(), 1e-12);
    }
    for (const double angle : {-0.8 * lean, 0.0, 0.4 * lean}) {
      const Vector3d up(0, std::sin(angle), std::cos(angle));
      const SurfacePoint above = canvas.closest(Vector3d(0.4, 0, 0) + 1e-3 * up);
      EXPECT_NEAR(above.distance, 1e-3, 1e-15);
      EXPECT_LT((above.n_W - up).norm(), 1e-12);
    }
  }
}

// A blunt edge stands for a smooth surface: the normal turns along the faces.
TEST(Canvas, NormalsAreSmoothedAcrossBluntEdges) {
  const double lean = 0.3;
  const Canvas canvas(roof(lean));
  const Vector3d side(0, std::sin(lean), std::cos(lean)), down(0, std::cos(lean), -std::sin(lean));
  const auto lean_at = [&](double off) {
    return std::asin(canvas.closest(Vector3d(0.5, 0, 0) + off * down + 1e-3 * side).n_W.y());
  };
  EXPECT_NEAR(lean_at(1e-9), 0.0, 1e-6);
  EXPECT_GT(lean_at(0.6), lean_at(0.3));
  EXPECT_LT(lean_at(0.6), lean);
}

TEST(Canvas, ClosestPointIsThatOfEveryTriangle) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    BowlSettings s;
    s.edge = 0.02;
    const TriangleMesh m = make_bowl(s);
    const Canvas canvas(m);
    for (int i = 0; i < 500; ++i) {
      const Vector3d p =
          Vector3d(0.6, 0, 0.2) + 0.3 * Vector3d(uniform(random), uniform(random), uniform(random));
      const SurfacePoint q = canvas.closest(p);
      const double distance = brute_distance(m, p);
      EXPECT_NEAR(std::abs(q.distance), distance, 1e-14);
      EXPECT_NEAR((p - q.p_W).norm(), distance, 1e-14);
      EXPECT_NEAR(q.n_W.norm(), 1, 1e-14);
      const auto& t = m.triangles.at(q.triangle);  // the point lies in the triangle that is named
      EXPECT_NEAR(brute_distance({m.vertices, {t}}, q.p_W), 0, 1e-14);
    }
  }
}

TEST(Canvas, LimitedSearchGivesTheSameOrNothing) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Canvas canvas(make_bowl());
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d p =
        Vector3d(0.6, 0, 0.12) +
        Vector3d(0.1 * uniform(random), 0.1 * uniform(random), 0.02 * uniform(random));
    const SurfacePoint all = canvas.closest(p);
    const auto near = canvas.closest(p, 0.01);
    ASSERT_EQ(near.has_value(), std::abs(all.distance) <= 0.01);
    if (!near) continue;
    ++found;
    EXPECT_EQ(near->triangle, all.triangle);
    EXPECT_EQ(near->p_W, all.p_W);
    EXPECT_EQ(near->distance, all.distance);
  }
  EXPECT_GT(found, 300);
  EXPECT_LT(found, 1700);
}

TEST(Canvas, StandardBowlMatchesTheSphere) {
  const BowlSettings s;
  const Canvas canvas(make_bowl(s));
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 5000; ++i) {
    const Vector3d out = Vector3d(0.5 * uniform(random), 0.5 * uniform(random), -1)
                             .normalized();  // at most 35.3° off the pole
    const double radius = 0.30 + 0.02 * uniform(random);
    const SurfacePoint q = canvas.closest(s.centre + radius * out);
    EXPECT_NEAR(q.distance, 0.30 - radius, 1.9e-6);
    EXPECT_LT((q.n_W - (s.centre - q.p_W).normalized()).norm(),
              1e-9);  // vertices on a sphere: exact
    EXPECT_LT((q.n_W + out).norm(),
              3e-4);  // the facet moves the closest point by its slope times the height
    EXPECT_FALSE(q.on_edge);
  }
}

TEST(Canvas, BeyondTheRimTheClosestPointIsOnTheEdge) {
  const BowlSettings s;
  const Canvas canvas(make_bowl(s));
  const Vector3d rim_centre(0.6, 0, 0.16);
  for (int i = 0; i < 360; ++i) {
    const Vector3d radial(std::cos(0.01745 * i), std::sin(0.01745 * i), 0);
    const SurfacePoint beyond = canvas.closest(rim_centre + 0.185 * radial + Vector3d(0, 0, 0.004));
    EXPECT_TRUE(beyond.on_edge);
    EXPECT_NEAR((beyond.p_W - rim_centre).head<2>().norm(), 0.18, 2e-6);
    const SurfacePoint within = canvas.closest(rim_centre + 0.178 * radial - Vector3d(0, 0, 0.001));
    EXPECT_FALSE(within.on_edge);
  }
}

TEST(Canvas, SignIsRightAroundSharpCornersToo) {
  TriangleMesh loose;  // the same solid as loose triangles, as an STL file has them
  const TriangleMesh solid = tetrahedron();
  for (const auto& t : solid.triangles) {
    const int first = int(loose.vertices.size());
    for (const int v : t) loose.vertices.push_back(solid.vertices[v]);
    loose.triangles.emplace_back(first, first + 1, first + 2);
  }
  for (const TriangleMesh& m : {solid, loose}) {
    const Canvas canvas(m);
    for (const unsigned seed : {1u, 2u}) {
      SCOPED_TRACE(seed);
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> uniform(-0.5, 1.5);
      int inside = 0;
      for (int i = 0; i < 20000; ++i) {
        const Vector3d p(uniform(random), uniform(random), 0.5 * uniform(random));
        const bool in = p.x() > 0 && p.y() > 0 && p.z() > 0 && p.x() + p.y() + p.z() / 0.2 < 1;
        inside += in;
        const SurfacePoint q = canvas.closest(p);
        EXPECT_EQ(q.distance < 0, in) << p.transpose();
        EXPECT_FALSE(q.on_edge);
      }
      EXPECT_GT(inside, 50);
    }
  }
}

TEST(Canvas, RayMeetsTheSphere) {
  const BowlSettings s;
  const Canvas canvas(make_bowl(s));
  const Vector3d eye(1.1, 0, 0.9);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 5000; ++i) {
    const Vector3d reference =
        s.centre + 0.3 * Vector3d(0.5 * uniform(random), 0.5 * uniform(random), -1).normalized();
    const Vector3d d = 1.7 * (reference - eye).normalized();
    const auto hit = canvas.ray(eye, d);
    ASSERT_TRUE(hit);
    // The farther intersection of line and sphere: the eye looks into the bowl over its
    // rim.
    const double b = d.dot(eye - s.centre), a = d.squaredNorm(),
                 c = (eye - s.centre).squaredNorm() - 0.09;
    const double t = (-b + std::sqrt(b * b - a * c)) / a;
    EXPECT_NEAR(hit->t, t, 6e-6);
    EXPECT_LT((hit->p_W - (eye + hit->t * d)).norm(), 1e-15);
    EXPECT_LT((hit->n_W - (s.centre - hit->p_W).normalized()).norm(), 1e-6);
  }
  EXPECT_FALSE(canvas.ray(eye, Vector3d::UnitZ()));
  EXPECT_FALSE(
      canvas.ray({0.6, 0, 0.11}, Vector3d::UnitZ()));  // starts above the bottom: nothing ahead
  EXPECT_FALSE(canvas.ray(eye, Vector3d::Zero()));
}

TEST(Canvas, RayOnATiltedPlaneIsExactInDoublePrecision) {
  const Vector3d n = Vector3d(0.2, -0.3, 1).normalized(), centre(0.6, 0.1, 0.1);
  const Canvas canvas(make_plane({.centre = centre, .normal = n, .edge = 0.007}));
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d from =
        centre + 0.5 * n + 0.2 * Vector3d(uniform(random), uniform(random), uniform(random));
    const Vector3d d = -n + 0.1 * Vector3d(uniform(random), uniform(random), uniform(random));
    const auto hit = canvas.ray(from, d);
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(hit->t, n.dot(centre - from) / n.dot(d), 1e-13);
    EXPECT_LT((hit->n_W - n).norm(), 1e-13);
  }
  EXPECT_GT(hits, 500);
}

TEST(Canvas, ThreadsGetTheSameAnswers) {
  const Canvas canvas(make_bowl());
  const auto limited = [&] {
    double total = 0;
    for (int i = 0; i < 20000; ++i)
      total += canvas.closest({0.5 + 1e-5 * i, 0.03, 0.13}, 0.05)->distance;
    return total;
  };
  const double alone = limited();
  std::array<double, 4> together{};
  std::vector<std::thread> threads;
  for (auto& value : together) threads.emplace_back([&] { value = limited(); });
  for (auto& thread : threads) thread.join();
  for (const double value : together) EXPECT_EQ(value, alone);
}

TEST(Canvas, QueryThatIsNotFiniteHasNoAnswer) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Canvas canvas(make_plane());
  EXPECT_EQ(canvas.closest({nan, 0, 0}).triangle, -1);
  EXPECT_TRUE(std::isnan(canvas.closest({nan, 0, 0}).distance));
  EXPECT_FALSE(canvas.closest({nan, 0, 0}, 0.1));
  EXPECT_FALSE(canvas.closest({0.6, 0, 0.1}, nan));
  EXPECT_FALSE(canvas.ray({0, 0, 1}, {nan, 0, -1}));
}

TEST(Canvas, TrianglesWithoutAreaAreHarmless) {
  TriangleMesh m = make_plane({.edge = 0.05});
  m.triangles.emplace_back(0, 1, 1);
  m.triangles.emplace_back(3, 3, 3);
  const Canvas canvas(m), clean(make_plane({.edge = 0.05}));
  for (double x = 0.3; x < 0.9; x += 0.013) {
    const SurfacePoint q = canvas.closest({x, 0.02, 0.13}), r = clean.closest({x, 0.02, 0.13});
    EXPECT_EQ(q.p_W, r.p_W);
    EXPECT_EQ(q.n_W, r.n_W);
    EXPECT_EQ(q.on_edge, r.on_edge);
  }
}

TEST(Canvas, RefusesABrokenMeshByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expect_refused = [](const TriangleMesh& m, const std::string& what) {
    try {
      Canvas canvas(m);
      ADD_FAILURE() << "accepted, though " << what;
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr(what));
    }
  };
  const TriangleMesh good = tetrahedron();
  EXPECT_NO_THROW(Canvas{good});
  expect_refused({}, "0 vertices and 0 triangles");
  TriangleMesh m = good;
  m.vertices[2].y() = nan;
  expect_refused(m, "vertex 2 is (0, nan, 0)");
  m = good;
  m.triangles[3][1] = 4;
  expect_refused(m, "triangle 3 names vertex 4, must be in 0 … 3");
  m = good;
  m.triangles[1] = {0, 3, 1};
  expect_refused(m, "wound against each other");
  m = good;
  m.triangles.emplace_back(0, 1, 2);
  expect_refused(m, "share the edge between vertices");
  expect_refused({good.vertices, {{0, 1, 1}}}, "has an area");
}

// A camera's rays over half of the image, rows and remainders of packets included. Where a ray hits
// the edge of two triangles, either may be taken, within the search in single precision.
TEST(Canvas, RaysInPacketsAreTheRaysOneByOne) {
  const std::vector<Canvas> canvases = [] {
    std::vector<Canvas> all;
    all.emplace_back(make_bowl({}));
    all.emplace_back(make_terrain({}));
    all.emplace_back(tetrahedron());
    return all;
  }();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const Canvas& canvas : canvases) {
    const Vector3d middle = canvas.bounds().center();
    const double size = canvas.bounds().diagonal().norm();
    long hits = 0, rays = 0, same = 0;
    for (int view = 0; view < 5; ++view) {
      const Vector3d eye = middle + size * Vector3d(uniform(random), uniform(random), 1.2);
      const Vector3d z = (middle - eye).normalized(), x = z.unitOrthogonal(), y = z.cross(x);
      for (int row = 0; row < 120; ++row) {
        std::vector<Vector3d> directions;
        for (int i = 0; i < 157; ++i)
          directions.push_back((z + (i - 78) * 6e-3 * x + (row - 60) * 6e-3 * y).normalized());
        std::vector<double> distances(directions.size());
        canvas.rays(eye, directions, distances);
        for (std::size_t i = 0; i < directions.size(); ++i, ++rays) {
          const auto one = canvas.ray(eye, directions[i]);
          if (one) {
            EXPECT_NEAR(distances[i], one->t, 1e-8);  // [m]
            same += distances[i] == one->t;
          } else {
            EXPECT_EQ(distances[i], std::numeric_limits<double>::infinity());
          }
          hits += one.has_value();
        }
      }
    }
    EXPECT_GT(hits, rays / 10);
    EXPECT_LT(hits, rays);
    EXPECT_GE(same, hits - 10);
  }
}

}  // namespace
}  // namespace impedraw

#include "impedraw/canvas/built_in.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "mesh_checks.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

double smallest_angle_deg(const TriangleMesh& m) {
  double smallest = 180;
  for (const auto& t : m.triangles) {
    for (int i = 0; i < 3; ++i) {
      const Vector3d u = m.vertices[t[(i + 1) % 3]] - m.vertices[t[i]];
      const Vector3d v = m.vertices[t[(i + 2) % 3]] - m.vertices[t[i]];
      smallest = std::min(smallest,
                          std::acos(u.normalized().dot(v.normalized())) * 180 / std::numbers::pi);
    }
  }
  return smallest;
}

TEST(Bowl, StandardBowlIsACapOfTheSphereDrawnOnFromInside) {
  const BowlSettings s;
  const TriangleMesh m = make_bowl(s);
  double lowest = 1, highest = 0;
  for (const auto& p : m.vertices) {
    EXPECT_NEAR((p - s.centre).norm(), s.radius, 1e-15);
    lowest = std::min(lowest, p.z());
    highest = std::max(highest, p.z());
  }
  EXPECT_NEAR(lowest, 0.10, 1e-15);
  EXPECT_NEAR(highest, 0.40 - 0.24, 1e-12);
  for (const auto& t : m.triangles) EXPECT_GT(cross(m, t).dot(s.centre - m.vertices[t[0]]), 0);
  EXPECT_NEAR(area(m), 2 * std::numbers::pi * 0.30 * (0.30 - 0.24), 2e-5 * 0.113);
  EXPECT_GT(smallest_angle_deg(m), 35);
  expect_disc(m);
}

TEST(Bowl, EdgesHaveTheWantedLengthAtEverySize) {
  for (const double edge : {0.0007, 0.004, 0.03, 0.18}) {
    SCOPED_TRACE(edge);
    BowlSettings s;
    s.edge = edge;
    const TriangleMesh m = make_bowl(s);
    for (const auto& t : m.triangles) {
      for (int i = 0; i < 3; ++i)
        EXPECT_LT((m.vertices[t[i]] - m.vertices[t[(i + 1) % 3]]).norm(), 1.45 * edge);
    }
    EXPECT_GT(smallest_angle_deg(m), 30);
    expect_disc(m);
  }
}

TEST(Dome, IsDrawnOnFromOutsideUpToTheHemisphere) {
  DomeSettings s{.radius = 0.2, .centre = {0.1, 0.2, 0.3}, .opening_radius = 0.2, .edge = 0.01};
  const TriangleMesh m = make_dome(s);
  for (const auto& p : m.vertices) EXPECT_GT(p.z(), 0.3 - 1e-12);
  for (const auto& t : m.triangles) EXPECT_GT(cross(m, t).dot(m.vertices[t[0]] - s.centre), 0);
  EXPECT_GT(smallest_angle_deg(m), 30);
  expect_disc(m);
}

TEST(Plane, HasItsSizeAndNormalHoweverItIsTilted) {
  for (const Vector3d& normal :
       {Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(-0.15, 0.1, 1), Vector3d(0, -1, -1)}) {
    PlaneSettings s{
        .centre = {1, 2, 3}, .normal = normal, .width = 0.3, .height = 0.2, .edge = 0.013};
    const TriangleMesh m = make_plane(s);
    const Vector3d n = normal.normalized();
    Vector3d mean = Vector3d::Zero();
    for (const auto& p : m.vertices) {
      EXPECT_NEAR(n.dot(p - s.centre), 0, 1e-14);
      mean += p / m.vertices.size();
    }
    EXPECT_LT((mean - s.centre).norm(), 1e-13);
    for (const auto& t : m.triangles) EXPECT_LT((cross(m, t).normalized() - n).norm(), 1e-12);
    EXPECT_NEAR(area(m), 0.06, 1e-14);
    expect_disc(m);
  }
}

TEST(BuiltIn, RefusesWhatMakesNoCanvas) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto bowl = [](auto&& change) {
    return [change] {
      BowlSettings s;
      change(s);
      make_bowl(s);
    };
  };
  expect_refused(bowl([](auto& s) { s.radius = 0; }),
                 "bowl.radius is 0 m, allowed is 0.01 to 10 m");
  expect_refused(bowl([&](auto& s) { s.edge = nan; }), "bowl.edge is nan m");
  expect_refused(bowl([](auto& s) { s.opening_radius = 0.31; }),
                 "opening_radius is 0.31 m, allowed is at most the radius, 0.3 m");
  expect_refused(bowl([](auto& s) { s.edge = 0.2; }),
                 "edge is 0.2 m, allowed is at most the opening_radius");
  expect_refused(bowl([](auto& s) { s.edge = 1e-6; }), "bowl.edge is 1e-06 m");
  expect_refused(bowl([&](auto& s) { s.centre.y() = nan; }), "bowl.centre is nan m");
  expect_refused([] { make_plane({.normal = Vector3d::Zero()}); }, "plane.normal");
  expect_refused([] { make_plane({.width = -1}); }, "plane.width is -1 m");
}

// Cells of a fifth of a millimetre would make tens of billions of triangles of ten metres.
TEST(BuiltIn, HasLongerEdgesWhereItIsLarge) {
  for (const TriangleMesh& mesh : {make_bowl({.radius = 10, .opening_radius = 10, .edge = 2e-4}),
                                   make_plane({.width = 10, .height = 10, .edge = 2e-4})}) {
    EXPECT_GT(mesh.triangles.size(), 1'500'000u);
    EXPECT_LT(mesh.triangles.size(), 2'500'000u);
  }
}

}  // namespace
}  // namespace impedraw

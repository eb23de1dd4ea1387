// The graphs and ruled canvases against their formulas, at random sizes and as they stand.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/built_in.h"
#include "impedraw/canvas/mesh_topology.h"
#include "mesh_checks.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

// A canvas and its formula.
struct Case {
  std::string name;
  TriangleMesh mesh;
  std::function<double(const Vector3d& p_W)>
      off{};  // 0 on the surface, > 0 on the side drawn on [m]; at least the distance
  std::function<Vector3d(const Vector3d& p_W)> normal{};  // outward, unit
  double most_off = 0;   // that a facet leaves the surface, from the header [m]
  double curvature = 0;  // greatest [1/m]
  double edge = 0;
  std::function<Vector2d(const Vector3d& p_W)>
      plan{};  // along and across, of the middle, in the shape's own directions [m]
  Vector2d half_size = Vector2d::Zero();    // of it [m]
  Vector3d kink = Vector3d::Constant(1e9);  // where the surface has no normal
};

Vector2d in_plan(const Vector3d& p, const Vector3d& middle, double heading_deg) {
  return Eigen::Rotation2Dd(-heading_deg * pi / 180) * Vector2d((p - middle).head<2>());
}

// A height over a rectangle, with its two slopes.
Case graph(const std::string& name, const FootprintSettings& s, TriangleMesh mesh,
           std::function<double(Vector2d)> h, std::function<Vector2d(Vector2d)> slope) {
  Case c{.name = name, .mesh = std::move(mesh), .edge = s.edge};
  c.plan = [s](const Vector3d& p) { return in_plan(p, s.centre, s.heading_deg); };
  c.half_size = {s.width / 2, s.height / 2};
  c.off = [s, h, plan = c.plan](const Vector3d& p) { return p.z() - s.centre.z() - h(plan(p)); };
  c.normal = [s, slope, plan = c.plan](const Vector3d& p) {
    const Vector2d g = Eigen::Rotation2Dd(s.heading_deg * pi / 180) * slope(plan(p));
    return Vector3d(-g.x(), -g.y(), 1).normalized();
  };
  return c;
}

Case wave(const WaveSettings& s) {
  const double k = 2 * pi / s.wavelength;
  Case c = graph(
      "wave", s.footprint, make_wave(s),
      [s, k](Vector2d p) { return s.amplitude * std::sin(k * p.x()); },
      [s, k](Vector2d p) { return Vector2d(s.amplitude * k * std::cos(k * p.x()), 0); });
  c.curvature = s.amplitude * k * k;
  c.most_off = c.edge * c.edge / 8 * c.curvature;
  return c;
}

Case saddle(const SaddleSettings& s) {
  Case c = graph(
      "saddle", s.footprint, make_saddle(s),
      [s](Vector2d p) { return (p.x() * p.x() - p.y() * p.y()) / (2 * s.radius); },
      [s](Vector2d p) { return Vector2d(p.x() / s.radius, -p.y() / s.radius); });
  c.curvature = 1 / s.radius;
  c.most_off = c.edge * c.edge / 8 / s.radius;
  return c;
}

Case terrain(const TerrainSettings& s) {
  std::mt19937_64 bits(s.seed);
  std::vector<Vector3d> waves;  // wave vector and phase
  for (int i = 0; i < 8; ++i) {
    Vector3d u;
    for (double& x : u) x = std::ldexp(double(bits() >> 11), -53);
    const double k = 2 * pi / (s.feature * (1 + u.x())), heading = pi / 8 * (i + u.y());
    waves.emplace_back(k * std::cos(heading), k * std::sin(heading), 2 * pi * u.z());
  }
  const auto h = [s, waves](Vector2d p) {
    double sum = 0;
    for (const Vector3d& w : waves) sum += s.amplitude / 8 * std::sin(w.head<2>().dot(p) + w.z());
    return sum;
  };
  const auto slope = [s, waves](Vector2d p) {
    Vector2d sum(0, 0);
    for (const Vector3d& w : waves)
      sum += s.amplitude / 8 * std::cos(w.head<2>().dot(p) + w.z()) * w.head<2>();
    return sum;
  };
  Case c = graph("terrain", s.footprint, make_terrain(s), h, slope);
  for (const Vector3d& p : c.mesh.vertices) {
    Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();
    for (const Vector3d& w : waves) {
      const Vector2d k = w.head<2>();
      hessian -= s.amplitude / 8 * std::sin(k.dot(c.plan(p)) + w.z()) * k * k.transpose();
    }
    c.curvature =
        std::max(c.curvature, std::abs(hessian.trace() / 2) +
                                  std::hypot((hessian(0, 0) - hessian(1, 1)) / 2, hessian(0, 1)));
  }
  c.most_off = c.edge * c.edge / 4 * c.curvature;
  return c;
}

Case cylinder(const CylinderSettings& s, double up) {  // −1: the trough
  Case c{.name = up > 0 ? "cylinder" : "trough",
         .mesh = up > 0 ? make_cylinder(s) : make_trough(s),
         .edge = s.edge};
  const Vector3d axis(std::cos(s.heading_deg * pi / 180), std::sin(s.heading_deg * pi / 180), 0);
  const auto from_axis = [s, axis, up](const Vector3d& p) -> Vector3d {
    const Vector3d r = p - (s.middle - up * s.radius * Vector3d::UnitZ());
    return r - axis * axis.dot(r);
  };
  c.off = [=](const Vector3d& p) { return up * (from_axis(p).norm() - s.radius); };
  c.normal = [=](const Vector3d& p) -> Vector3d { return up * from_axis(p).normalized(); };
  c.curvature = 1 / s.radius;
  c.most_off = c.edge * c.edge / 8 / s.radius;
  c.plan = [s](const Vector3d& p) { return in_plan(p, s.middle, s.heading_deg); };
  c.half_size = {s.length / 2, s.width / 2};
  return c;
}

Case cone(const ConeSettings& s) {
  Case c{.name = "cone", .mesh = make_cone(s), .edge = s.edge};
  const double slope = s.slope_deg * pi / 180;
  c.off = [=](const Vector3d& p) {
    const Vector3d r = p - s.apex;
    return r.z() * std::cos(slope) + r.head<2>().norm() * std::sin(slope);
  };
  c.normal = [=](const Vector3d& p) {
    const Vector2d out = (p - s.apex).head<2>().normalized() * std::sin(slope);
    return Vector3d(out.x(), out.y(), std::cos(slope));
  };
  c.most_off = c.edge * c.edge * std::sin(slope) / s.base_radius;
  c.curvature = std::sin(slope) / (s.base_radius / 8);  // where normals are compared
  c.plan = [s](const Vector3d& p) { return in_plan(p, s.apex, 0); };
  c.half_size = {s.base_radius, s.base_radius};
  c.kink = s.apex;
  return c;
}

std::vector<Case> as_they_stand() {
  return {wave({}), saddle({}), terrain({}), cylinder({}, 1), cylinder({}, -1), cone({})};
}

std::vector<Case> random_cases(unsigned seed) {
  std::mt19937 random(seed);
  const auto from = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto footprint = [&] {
    return FootprintSettings{{from(-1, 1), from(-1, 1), from(-1, 1)},
                             from(-180, 180),
                             from(0.1, 0.3),
                             from(0.1, 0.3),
                             from(0.003, 0.009)};
  };
  const auto round = [&] {
    const double radius = from(0.1, 0.5);
    return CylinderSettings{{from(-1, 1), from(-1, 1), from(-1, 1)},
                            from(-180, 180),
                            radius,
                            from(0.1, 0.3),
                            radius * from(0.2, 2),
                            from(0.003, 0.009)};
  };
  return {
      wave({footprint(), from(0.002, 0.03), from(0.08, 0.3)}),
      saddle({footprint(), from(0.1, 1)}),
      terrain({footprint(), static_cast<int>(random() % 1000), from(0.005, 0.04), from(0.08, 0.3)}),
      cylinder(round(), 1),
      cylinder(round(), -1),
      cone({{from(-1, 1), from(-1, 1), from(-1, 1)},
            from(5, 80),
            from(0.05, 0.2),
            from(0.003, 0.009)})};
}

// Properties of every shape.
void check(const Case& c) {
  SCOPED_TRACE(c.name);
  const TriangleMesh& m = c.mesh;
  Vector2d low = Vector2d::Constant(1e9), high = -low;
  double vertex_off = 0;
  for (const Vector3d& p : m.vertices) {
    vertex_off = std::max(vertex_off, std::abs(c.off(p)));
    low = low.cwiseMin(c.plan(p));
    high = high.cwiseMax(c.plan(p));
  }
  EXPECT_LT(vertex_off, 1e-14);
  EXPECT_NEAR(high.x(), c.half_size.x(), 1e-12);
  const double polygon =
      c.name == "cone" ? 2e-3
                       : 1e-12;  // a ring seldom has a vertex exactly at its left, top or bottom
  EXPECT_NEAR(high.y(), c.half_size.y(), polygon);
  EXPECT_LT((low + c.half_size).cwiseAbs().maxCoeff(), polygon);

  double most_off = 0, most_turned = 0;
  int slivers = 0, faces_away = 0;
  for (const auto& t : m.triangles) {
    const Vector3d &a = m.vertices[t[0]], &b = m.vertices[t[1]], &d = m.vertices[t[2]],
                   middle = (a + b + d) / 3;
    const double longest = std::max({(a - b).norm(), (b - d).norm(), (d - a).norm()});
    slivers += cross(m, t).norm() < 0.05 * longest * longest;
    faces_away += !(cross(m, t).dot(c.normal(middle)) > 0);
    for (const Vector3d& p :
         {middle, Vector3d((a + b) / 2), Vector3d((b + d) / 2), Vector3d((d + a) / 2)}) {
      most_off = std::max(most_off, std::abs(c.off(p)));
    }
    if ((middle - c.kink).norm() < c.half_size.x() / 8) continue;
    most_turned = std::max(most_turned, cross(m, t).normalized().cross(c.normal(middle)).norm());
  }
  EXPECT_EQ(slivers, 0);
  EXPECT_EQ(faces_away, 0);
  EXPECT_LT(most_off, 1.01 * c.most_off + 1e-14);
  EXPECT_GT(most_off, 0.2 * c.most_off) << "the bound in the header says too little";
  EXPECT_LT(most_turned, c.curvature * c.edge);

  // throws if neighbours have opposite winding
  const MeshTopology around = make_topology(m);
  ASSERT_GE(around.smooth_normal.size(), m.vertices.size()) << "vertices at the same place";
  double vertex_turned = 0;
  for (std::size_t i = 0; i < m.vertices.size(); ++i) {
    if (around.on_boundary[i] || (m.vertices[i] - c.kink).norm() < c.half_size.x() / 8) continue;
    vertex_turned =
        std::max(vertex_turned, (around.smooth_normal[i] - c.normal(m.vertices[i])).norm());
  }
  EXPECT_LT(vertex_turned, 0.25 * c.curvature * c.edge);
}

TEST(BuiltInShapes, LieOnTheirFormulasAndFaceOutward) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    SCOPED_TRACE(seed);
    for (const Case& c : random_cases(seed)) {
      check(c);
      expect_disc(c.mesh);
    }
  }
}

TEST(BuiltInShapes, AsTheyStandNoFacetIsTenMicrometresOff) {
  for (const Case& c : as_they_stand()) {
    check(c);
    double most_off = 0;
    for (const auto& t : c.mesh.triangles) {
      for (int i = 0; i < 3; ++i) {
        most_off = std::max(
            most_off,
            std::abs(c.off((c.mesh.vertices[t[i]] + c.mesh.vertices[t[(i + 1) % 3]]) / 2)));
      }
    }
    EXPECT_LT(most_off, 10e-6) << c.name;
  }
}

TEST(BuiltInShapes, OpenAsWideAsAsked) {
  EXPECT_NEAR(area(make_cylinder({.radius = 0.2, .length = 0.3, .width = 0.4})), pi * 0.2 * 0.3,
              1e-6);  // half a cylinder
  const double slope = 80 * pi / 180;
  const TriangleMesh dome = make_dome({.radius = 0.15, .opening_radius = 0.15 * std::sin(slope)});
  EXPECT_NEAR(area(dome), 2 * pi * 0.15 * 0.15 * (1 - std::cos(slope)), 1e-5);
  double steepest = 0;
  for (const auto& t : dome.triangles)
    steepest = std::max(steepest, std::acos(cross(dome, t).normalized().z()));
  EXPECT_NEAR(steepest, slope, 0.01);
  EXPECT_NEAR(area(make_cone({.slope_deg = 60, .base_radius = 0.1})),
              pi * 0.1 * 0.1 / std::cos(pi / 3), 1e-5);
}

TEST(Terrain, IsTheSeeds) {
  TerrainSettings s;
  s.footprint.edge = 0.01;
  s.seed = 7;
  const TriangleMesh first = make_terrain(s), again = make_terrain(s);
  EXPECT_EQ(first.vertices, again.vertices);
  s.seed = 8;
  double apart = 0, highest = 0;
  const TriangleMesh other = make_terrain(s);
  for (std::size_t i = 0; i < first.vertices.size(); ++i) {
    apart = std::max(apart, (first.vertices[i] - other.vertices[i]).norm());
    highest = std::max(highest, std::abs(first.vertices[i].z() - s.footprint.centre.z()));
  }
  EXPECT_GT(apart, 0.005);
  EXPECT_LT(highest, s.amplitude);
  EXPECT_GT(highest, 0.2 * s.amplitude);
}

// Two corners and the middle [m], from an independent Python implementation of generator and sum:
// guards against a change of the surface.
TEST(Terrain, StaysTheSurfaceThatItWas) {
  TerrainSettings s;
  s.footprint.edge = 0.01;  // 36 × 36 cells
  const TriangleMesh m = make_terrain(s);
  ASSERT_EQ(m.vertices.size(), 37u * 37u);
  EXPECT_NEAR(m.vertices.front().z(), 0.0797640554635049, 1e-14);
  EXPECT_NEAR(m.vertices[37 * 18 + 18].z(), 0.1022991270244489, 1e-14);
  EXPECT_NEAR(m.vertices.back().z(), 0.11625159572097937, 1e-14);
}

// Cells of 1.5 mm would show another wave than one of 8 mm.
TEST(BuiltInShapes, HaveCellsThatShowTheirWaves) {
  WaveSettings fine{.footprint = {.width = 0.1, .height = 0.01}, .wavelength = 0.008};
  EXPECT_EQ(make_wave(fine).vertices.size(), 101u * 11u);
  TerrainSettings hills{.footprint = {.width = 0.1, .height = 0.01}, .feature = 0.008};
  EXPECT_EQ(make_terrain(hills).vertices.size(), 101u * 11u);
}

TEST(BuiltInShapes, RefuseWhatMakesNoCanvas) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_refused([] { make_wave({.footprint = {}, .amplitude = 0}); },
                 "wave.amplitude is 0 m, allowed is 1e-04 to 1 m");
  expect_refused([&] { make_wave({.footprint = {}, .wavelength = nan}); },
                 "wave.wavelength is nan m");
  expect_refused(
      [&] {
        make_wave({.footprint = {.centre = {0, nan, 0}}});
      },
      "wave.centre is nan m");
  expect_refused([&] { make_wave({.footprint = {.heading_deg = nan}}); },
                 "wave.heading is nan deg");
  expect_refused([] { make_saddle({.footprint = {}, .radius = -0.1}); }, "saddle.radius is -0.1 m");
  expect_refused([] { make_saddle({.footprint = {.height = 0}}); }, "saddle.height is 0 m");
  expect_refused([] { make_terrain({.footprint = {}, .amplitude = -1}); },
                 "terrain.amplitude is -1 m");
  expect_refused([] { make_cylinder({.width = 0.61}); },
                 "cylinder.width is 0.61 m, allowed is at most twice the radius, 0.6 m");
  expect_refused([] { make_trough({.length = 0}); }, "trough.length is 0 m");
  expect_refused([] { make_trough({.width = 0.05, .edge = 0.1}); },
                 "trough.edge is 0.1 m, allowed is at most the width, 0.05 m");
  expect_refused([] { make_cone({.slope_deg = 0}); },
                 "cone.slope is 0 deg, allowed is 0.1 to 80 deg");
  expect_refused([&] { make_cone({.slope_deg = nan}); }, "cone.slope is nan deg");
  expect_refused([] { make_cone({.slope_deg = 81}); }, "cone.slope is 81 deg");
  expect_refused([] { make_cone({.base_radius = 0.09, .edge = 0.1}); },
                 "cone.edge is 0.1 m, allowed is at most the base_radius, 0.09 m");
}

}  // namespace
}  // namespace impedraw

// A tip among open sheets: fins, flaps and boxes without a lid, wound either way. Brute force over
// all triangles tells how near they are.
#include "impedraw/simulation/tip_side.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "seeds.h"
#include "worlds.h"

namespace impedraw {
namespace {

using namespace testing_worlds;
using Eigen::Vector3d;

constexpr double kRadius = 1e-3;

double to_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const double s = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (a + s * (b - a) - p).norm();
}

// Of p from all triangles, without a sign.
double brute_distance(const TriangleMesh& mesh, const Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3d &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vector3d n = (b - a).cross(c - a).normalized();
    const Vector3d q = p - n.dot(p - a) * n;
    const bool over = n.dot((b - a).cross(q - a)) >= 0.0 && n.dot((c - b).cross(q - b)) >= 0.0 &&
                      n.dot((a - c).cross(q - c)) >= 0.0;
    if (over) least = std::min(least, std::abs(n.dot(p - a)));
    least = std::min({least, to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a)});
  }
  return least;
}

void add_rectangle(const Vector3d& corner, const Vector3d& u, const Vector3d& v, bool turned,
                   TriangleMesh* mesh) {
  const int first = static_cast<int>(mesh->vertices.size());
  mesh->vertices.insert(mesh->vertices.end(), {corner, corner + u, corner + u + v, corner + v});
  const int b = turned ? 3 : 1, d = turned ? 1 : 3;
  mesh->triangles.push_back({first, first + b, first + 2});
  mesh->triangles.push_back({first, first + 2, first + d});
}

// A plate of 60 mm with fins at random, upright and leaning, and a box without its lid.
TriangleMesh sheets(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto turned = [&] { return unit(random) > 0.0; };
  TriangleMesh mesh;
  add_rectangle({-0.03, -0.03, 0}, {0.06, 0, 0}, {0, 0.06, 0}, false, &mesh);
  for (int i = 0; i < 4; ++i) {
    const double angle = 3.0 * unit(random);
    const Vector3d along = 0.01 * Vector3d(std::cos(angle), std::sin(angle), 0.0);
    const Vector3d up(2e-3 * unit(random), 2e-3 * unit(random), 0.008);
    add_rectangle({0.02 * unit(random), 0.02 * unit(random), 1e-4}, along, up, turned(), &mesh);
  }
  const Vector3d corner(0.02 * unit(random), 0.02 * unit(random), 2e-4);
  const double side = 8e-3;
  const bool inward = turned();
  const Vector3d x = side * Vector3d::UnitX(), y = side * Vector3d::UnitY(),
                 z = side * Vector3d::UnitZ();
  add_rectangle(corner, y, x, inward, &mesh);
  add_rectangle(corner, x, z, inward, &mesh);
  add_rectangle(corner, z, y, inward, &mesh);
  add_rectangle(corner + x, y, z, inward, &mesh);
  add_rectangle(corner + y, z, x, inward, &mesh);
  return mesh;
}

TEST(TipSide, IsClearByTheDistanceOfFreeAirFromWhateverSide) {
  for (unsigned seed = 0; seed < seeds(10, 200); ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const TriangleMesh mesh = sheets(random);
    const Canvas canvas(mesh);
    TipSide side;
    Vector3d c(0.0, 0.0, 0.02), v = Vector3d::Zero();
    int near = 0, behind = 0;
    for (int i = 0; i < 20000; ++i) {
      v = 0.98 * v + 5e-5 * Vector3d(unit(random), unit(random), unit(random) - 0.03);
      const double free = brute_distance(mesh, c + v);
      // So near that it is touched, but never through: a step is shorter than what is left.
      if (free < std::max(0.3 * kRadius, 1.01 * v.norm()) || (c + v).cwiseAbs().maxCoeff() > 0.03) {
        v = -v;
        continue;
      }
      c += v;
      const auto closest = canvas.closest(c, 10.0 * kRadius);
      if (!closest) {
        side.leave();
        continue;
      }
      const TipFacing facing = side.update(c, *closest, kRadius);
      ASSERT_NEAR(facing.clear, free, 1e-9) << i;
      ASSERT_NEAR(facing.n.norm(), 1.0, 1e-9);
      ASSERT_GT(facing.n.dot(c - closest->p_W), 0.0) << i;
      ++near;
      behind += closest->distance < 0.0;
    }
    EXPECT_GT(near, 5000);
    EXPECT_GT(behind, 500);
  }
}

TEST(TipSide, StaysWhereTheTipCameFromUntilItIsOut) {
  for (const bool turned : {false, true})
    for (const double from : {1.0, -1.0}) {
      TriangleMesh mesh;
      add_rectangle({-0.05, -0.05, 0}, {0.1, 0, 0}, {0, 0.1, 0}, turned, &mesh);
      const Canvas canvas(mesh);
      TipSide side;
      const auto at = [&](double height) {
        const Vector3d c(0.003, 0.001, from * height);
        return side.update(c, canvas.closest(c), kRadius);
      };
      for (double z = 8e-3; z > -6e-3; z -= 1.3e-4) {
        const TipFacing facing = at(z);
        EXPECT_NEAR(facing.clear, z, 1e-12);
        EXPECT_NEAR(facing.n.z(), from, 1e-12);
      }
      EXPECT_NEAR(at(5e-3).clear, 5e-3, 1e-12) << "back in one leap";
      EXPECT_NEAR(at(-5e-3).clear, -5e-3, 1e-12);
      side.leave();
      EXPECT_NEAR(at(-5e-3).clear, 5e-3, 1e-12) << "come from there";
    }
}

TEST(TipSide, BeginsInContactWithAFrontOrBesideABack) {
  TriangleMesh mesh;
  add_rectangle({-0.05, -0.05, 0}, {0.1, 0, 0}, {0, 0.1, 0}, false, &mesh);
  const Canvas canvas(mesh);
  for (const double z : {2e-3, 5e-4, -5e-4, -2e-3}) {
    TipSide side;
    const Vector3d c(0.0, 0.0, z);
    EXPECT_NEAR(side.update(c, canvas.closest(c), kRadius).clear, z < -kRadius ? -z : z, 1e-12);
  }
}

// As a pen rises from a plate beside a sheet that shows it its back: nothing touches it.
TEST(TipSide, AGlidingTipIsNotPushedByABackThatItPasses) {
  for (const bool turned : {false, true}) {
    TriangleMesh mesh;
    add_rectangle({-0.1, -0.1, 0}, {0.2, 0, 0}, {0, 0.2, 0}, false, &mesh);
    add_rectangle({0.008, -0.03, 1e-3}, {0, 0.06, 0}, {0, 0, 0.03}, turned, &mesh);
    const Canvas canvas(mesh);
    WorldSettings settings;
    settings.gravity = 0.0;
    World world(kSlider, &canvas, settings);
    const JointVector v = 0.05 * JointVector::Unit(3, 2);
    world.set_state(0.002 * JointVector::Unit(3, 2), v);
    for (int i = 0; i < 500; ++i) {
      EXPECT_FALSE(world.step(JointVector::Zero(3), Vector3d::Zero()).touching) << i;
      ASSERT_LT((world.state().v - v).norm(), 1e-9) << i;
    }
  }
}

// The upper rim of a sheet that stands upright bears a tip that comes down on it, on either side of
// its plane.
TEST(TipSide, ARimPushesAwayFromItself) {
  for (const double off : {-3e-4, -1e-6, 1e-6, 3e-4}) {
    TriangleMesh mesh;
    add_rectangle({0.0, -0.05, -0.02}, {0, 0.1, 0}, {0, 0, 0.02}, false, &mesh);
    const Canvas canvas(mesh);
    WorldSettings settings;
    settings.gravity = 0.0;
    World world(kSlider, &canvas, settings);
    JointVector q = JointVector::Zero(3);
    q[0] = off;
    q[2] = 2e-3;
    world.set_state(q, -0.05 * JointVector::Unit(3, 2));
    const TipContact* contact = nullptr;
    for (int i = 0; i < 100 && !(contact && contact->touching); ++i)
      contact = &world.step(JointVector::Zero(3), Vector3d::Zero());
    ASSERT_TRUE(contact->touching);
    const Vector3d n(off, 0.0, std::sqrt(kRadius * kRadius - off * off));
    EXPECT_LT((contact->n_W - n / kRadius).norm(), 0.02);
  }
}

}  // namespace
}  // namespace impedraw

// A tip among open sheets: fins, flaps and boxes without a lid, wound either way; brute force over
// all triangles tells how near they are. And a tip that touches several things at a time, against
// closed forms.
#include "impedraw/simulation/tip_touches.h"

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

TEST(TipTouches, IsClearByTheDistanceOfFreeAirFromWhateverSide) {
  int several = 0;
  for (unsigned seed = 0; seed < seeds(10, 200); ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const TriangleMesh mesh = sheets(random);
    const Canvas canvas(mesh);
    TipTouches tip;
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
      const auto touches = tip.update(canvas, c, kRadius);
      if (touches.empty()) {
        ASSERT_GT(free, 10.0 * kRadius);
        continue;
      }
      ASSERT_NEAR(touches[0].clear, free, 1e-9) << i;
      for (const TipTouch& touch : touches) {
        ASSERT_NEAR(touch.clear, (c - touch.p).norm(), 1e-9) << i;
        ASSERT_NEAR(touch.n.norm(), 1.0, 1e-9);
        ASSERT_GT(touch.n.dot(c - touch.p), 0.0) << i;
      }
      ++near;
      several += touches.size() > 1;
      behind += canvas.closest(c).distance < 0.0;
    }
    EXPECT_GT(near, 5000);
    EXPECT_GT(behind, 500);
  }
  EXPECT_GT(several, 200);
}

TEST(TipTouches, StaysWhereTheTipCameFromUntilItIsOut) {
  for (const bool turned : {false, true})
    for (const double from : {1.0, -1.0}) {
      TriangleMesh mesh;
      add_rectangle({-0.05, -0.05, 0}, {0.1, 0, 0}, {0, 0.1, 0}, turned, &mesh);
      const Canvas canvas(mesh);
      TipTouches tip;
      const auto at = [&](double height) {
        const auto touches = tip.update(canvas, {0.003, 0.001, from * height}, kRadius);
        EXPECT_EQ(touches.size(), 1u);
        return touches[0];
      };
      for (double z = 8e-3; z > -6e-3; z -= 1.3e-4) {
        const TipTouch touch = at(z);
        EXPECT_NEAR(touch.clear, z, 1e-12);
        EXPECT_NEAR(touch.n.z(), from, 1e-12);
      }
      EXPECT_NEAR(at(5e-3).clear, 5e-3, 1e-12) << "back in one leap";
      EXPECT_NEAR(at(-5e-3).clear, -5e-3, 1e-12);
      EXPECT_TRUE(tip.update(canvas, {0.0, 0.0, 0.02}, kRadius).empty());
      EXPECT_NEAR(at(-5e-3).clear, 5e-3, 1e-12) << "come from there";
    }
}

TEST(TipTouches, BeginsInContactWithAFrontOrBesideABack) {
  TriangleMesh mesh;
  add_rectangle({-0.05, -0.05, 0}, {0.1, 0, 0}, {0, 0.1, 0}, false, &mesh);
  const Canvas canvas(mesh);
  for (const double z : {2e-3, 5e-4, -5e-4, -2e-3}) {
    TipTouches tip;
    EXPECT_NEAR(tip.update(canvas, {0.0, 0.0, z}, kRadius)[0].clear, z < -kRadius ? -z : z, 1e-12);
  }
}

// As a pen rises from a plate beside a sheet that shows it its back: nothing touches it.
TEST(TipTouches, AGlidingTipIsNotPushedByABackThatItPasses) {
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
TEST(TipTouches, ARimPushesAwayFromItself) {
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

TEST(TipTouches, FindsEachWallOfAGrooveAndNoneBehindAnother) {
  // A plate, a wall upon it, and a wall beneath it.
  TriangleMesh mesh;
  add_rectangle({-0.03, -0.03, 0}, {0.06, 0, 0}, {0, 0.06, 0}, false, &mesh);
  add_rectangle({8e-4, -0.03, 1e-4}, {0, 0.06, 0}, {0, 0, 0.01}, true, &mesh);
  add_rectangle({-0.03, 5e-4, -1e-2}, {0.06, 0, 0}, {0, 0, 9.9e-3}, true, &mesh);
  const Canvas canvas(mesh);
  TipTouches tip;
  const auto touches = tip.update(canvas, {0.0, 0.0, 7e-4}, kRadius);
  ASSERT_EQ(touches.size(), 2u);
  EXPECT_LT((touches[0].n - Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(touches[0].clear, 7e-4, 1e-12);
  EXPECT_LT((touches[1].n + Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_NEAR(touches[1].clear, 8e-4, 1e-12);
}

// Two half planes along y that meet in the origin, each inclined by `slope` towards it.
Canvas groove(double slope) {
  const double far = 0.03;
  const Vector3d left(-far * std::cos(slope), -far, far * std::sin(slope)), y(0, 2 * far, 0);
  const Vector3d right = left.cwiseProduct(Vector3d(-1, 1, 1)), middle(0, -far, 0);
  return Canvas({{left, middle, middle + y, left + y, right, right + y},
                 {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}}});
}

WorldSettings without_gravity(double friction, double damping = 60.0) {
  WorldSettings settings;
  settings.gravity = 0.0;
  settings.tip.friction = friction;
  settings.tip.damping = damping;
  return settings;
}

// The slider at rest with the ball's centre at c; its tip points down.
void place(World& world, const Vector3d& c) {
  world.set_state(c - Vector3d(0, 0, 1e-3), JointVector::Zero(3));
}

// Pressed into a groove by F the ball sinks until each wall bears F/(2 cos α); on the way there it
// leaves the middle for neither wall.
TEST(TipTouches, AGrooveBearsTheBallOnBothWalls) {
  for (const double slope : {0.4, 0.7, 1.0})
    for (const double friction : {0.0, 0.3}) {
      SCOPED_TRACE(slope);
      const Canvas canvas = groove(slope);
      World world(kSlider, &canvas, without_gravity(friction, 600.0));
      place(world, {0.0, 0.0, kRadius / std::cos(slope)});
      const double F = 5.0;
      for (int i = 0; i < 3000; ++i) world.step(JointVector::Zero(3), {0.0, 0.0, -F});
      const double clear = (world.state().X_WE.p.z() + kRadius) * std::cos(slope);
      const double phi = kRadius - clear, bound = F / (2.0 * std::cos(slope) * 20e3);
      // Friction bears a part of it.
      EXPECT_LE(phi, bound + 1e-9);
      EXPECT_GE(phi, bound / (1.0 + friction * std::tan(slope)) - 1e-9);
      EXPECT_NEAR(world.state().X_WE.p.x(), 0.0, 1e-9);
      EXPECT_NEAR(world.step(JointVector::Zero(3), {0.0, 0.0, -F}).f_W.z(), F, 1e-6);
      EXPECT_EQ(world.cutoffs().joints, 0);
    }
}

// Pulled along a groove, each wall brakes it by μ times what it bears: μ F / cos α in all.
TEST(TipTouches, FrictionInAGrooveIsThatOfBothWalls) {
  const double slope = 0.7, friction = 0.2, F = 5.0;
  const Canvas canvas = groove(slope);
  World world(kSlider, &canvas, without_gravity(friction, 600.0));
  place(world, {0.0, -0.02, kRadius / std::cos(slope)});
  const double most = friction * F / std::cos(slope);
  for (int i = 0; i < 1000; ++i) world.step(JointVector::Zero(3), {0.0, 0.7 * most, -F});
  EXPECT_LT(std::abs(world.state().v[1]), 1e-6) << "held";
  double brake = 0.0;
  for (int i = 0; i < 300; ++i)
    brake = world.step(JointVector::Zero(3), {0.0, 1.2 * most, -F}).f_W.y();
  EXPECT_NEAR(brake, -most, 0.01 * most);
  EXPECT_GT(world.state().v[1], 1e-3);
}

// Between two planes 2 (r − φ) apart the ball oscillates with twice the stiffness, about their
// middle, and neither gains energy.
TEST(TipTouches, TwoPlanesHoldTheBallWithTwiceTheStiffness) {
  const double phi = 2e-4, apart = 2.0 * (kRadius - phi), k = 20e3;
  TriangleMesh mesh;
  add_rectangle({-0.05, -0.05, 0}, {0.1, 0, 0}, {0, 0.1, 0}, false, &mesh);
  add_rectangle({-0.05, -0.05, apart}, {0.1, 0, 0}, {0, 0.1, 0}, true, &mesh);
  const Canvas canvas(mesh);
  WorldSettings settings = without_gravity(0.0, 0.0);
  settings.substeps = 20;
  World world(kSlider, &canvas, settings);
  const double off = 1e-4;
  place(world, {0.0, 0.0, apart / 2.0 + off});
  const double m = world.terms().M(2, 2), omega = std::sqrt(2.0 * k / m);
  double most = 0.0;
  for (int i = 1; i <= 400; ++i) {
    const TipContact& contact = world.step(JointVector::Zero(3), Vector3d::Zero());
    const double z = world.state().X_WE.p.z() + kRadius - apart / 2.0;
    ASSERT_NEAR(z, off * std::cos(omega * 1e-3 * i), 0.05 * off) << i;
    ASSERT_LT(std::abs(contact.f_W.z()), 2.0 * k * off * 1.02);
    most = std::max(most, k * z * z + 0.5 * m * world.state().v[2] * world.state().v[2]);
  }
  EXPECT_LT(most, 1.03 * k * off * off);
}

// Over the edge of a step a ball that lies on the upper face touches one thing, on the lower face
// beside it two: the face and the edge or the riser.
TEST(TipTouches, AStepIsTouchedAtItsEdgeFromAboveAndFromBeside) {
  TriangleMesh mesh;
  add_rectangle({-0.03, -0.03, 0}, {0.03, 0, 0}, {0, 0.06, 0}, false, &mesh);
  add_rectangle({0, -0.03, 0}, {0, 0, 5e-4}, {0, 0.06, 0}, false, &mesh);
  add_rectangle({0, -0.03, 5e-4}, {0.03, 0, 0}, {0, 0.06, 0}, false, &mesh);
  const Canvas canvas(mesh);
  const auto at = [&](double x, double z) {
    TipTouches tip;
    const auto touches = tip.update(canvas, {x, 0.0, z}, kRadius);
    return std::vector<TipTouch>(touches.begin(), touches.end());
  };
  EXPECT_EQ(at(2e-3, 1.4e-3).size(), 1u);
  const auto beside = at(-7e-4, 9e-4);
  ASSERT_EQ(beside.size(), 2u);
  const Vector3d to_edge(-7e-4, 0.0, 4e-4);
  EXPECT_LT((beside[0].n - to_edge.normalized()).norm(), 1e-9);
  EXPECT_NEAR(beside[0].clear, to_edge.norm(), 1e-12);
  EXPECT_LT((beside[1].n - Vector3d::UnitZ()).norm(), 1e-9);
  EXPECT_NEAR(beside[1].clear, 9e-4, 1e-12);
}

// The force on a ball that is led through a groove or a row of parallel wires, by a spring for each
// place: it changes with the way, by no more than a stiffness times the way.
TEST(TipTouches, TheForceHasNoJumpWhereTheNearestPlaceChanges) {
  const double step = 2e-6;
  for (const double apart : {0.3e-3, 0.5e-3, 0.9e-3, 1.3e-3}) {
    TriangleMesh mesh;  // ridges' sharp edges, `apart` from each other
    for (int i = -3; i <= 3; ++i)
      add_rectangle({i * apart, -0.03, -5e-3}, {0, 0.06, 0}, {0, 0, 5e-3}, i % 2 == 0, &mesh);
    const Canvas canvas(mesh);
    for (const double height : {0.75e-3, 0.85e-3, 0.95e-3}) {
      if (height * height + apart * apart / 4.0 > kRadius * kRadius) continue;
      TipTouches tip;
      Vector3d last = Vector3d::Zero();
      for (double x = -apart; x < apart; x += step) {
        Vector3d force = Vector3d::Zero();
        for (const TipTouch& touch : tip.update(canvas, {x, 0.0, height}, kRadius))
          force += touch.share * (kRadius - touch.clear) * touch.n;
        if (x > -apart) {
          ASSERT_LT((force - last).norm(), 0.05e-3) << apart << " " << x;
        }
        last = force;
      }
    }
  }
}

}  // namespace
}  // namespace impedraw

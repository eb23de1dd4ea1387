// A copy of the arm's body hides what MuJoCo's own rays find, to the last bit.
#include "impedraw/simulation/posed_body.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "worlds.h"

namespace impedraw {
namespace {

using namespace testing_worlds;
using Eigen::Vector3d;

TEST(PosedBody, HidesWhatTheArmHides) {
  constexpr double kNothing = std::numeric_limits<double>::infinity();
  World world(kArm, nullptr, {});
  std::mt19937 random(1);
  PosedBody body;
  long hits = 0;
  for (int posture = 0; posture < 6; ++posture) {
    const JointVector q = working_posture() + random_vector(random, 7, 0.6);
    world.set_state(q, JointVector::Zero(7));
    world.copy_body(&body);
    const Vector3d eye =
        Vector3d(0.6, 0.0, 0.9) + Vector3d(random_vector(random, 7, 0.5).head<3>());
    const Vector3d z = (Vector3d(0.3, 0.0, 0.4) - eye).normalized(), x = z.unitOrthogonal(),
                   y = z.cross(x);
    for (int row = 0; row < 60; ++row) {
      std::vector<Vector3d> directions;
      for (int i = 0; i < 83; ++i)
        directions.push_back((z + (i - 40) * 0.015 * x + (row - 30) * 0.015 * y).normalized());
      std::vector<double> all(directions.size(), kNothing), finite(directions.size());
      for (std::size_t i = 0; i < finite.size(); ++i) finite[i] = i % 3 == 0 ? kNothing : 0.7;
      body.cover(eye, directions, all, PosedBody::Rays::all);
      body.cover(eye, directions, finite, PosedBody::Rays::finite);
      for (std::size_t i = 0; i < directions.size(); ++i) {
        const double one = world.ray_to_arm(eye, directions[i]);
        ASSERT_EQ(all[i], one);
        ASSERT_EQ(finite[i], i % 3 == 0 ? kNothing : std::min(0.7, one));
        hits += std::isfinite(one);
      }
    }
  }
  EXPECT_GT(hits, 2000);
}

// The arm moves on, and the copy stays.
TEST(PosedBody, StaysWhereItWas) {
  World world(kArm, nullptr, {});
  PosedBody body;
  world.set_state(working_posture(), JointVector::Zero(7));
  world.copy_body(&body);
  const Vector3d p = body.shapes.back().p_W;
  world.set_state(JointVector::Constant(7, 0.3), JointVector::Zero(7));
  EXPECT_EQ(body.shapes.back().p_W, p);
  PosedBody moved;
  world.copy_body(&moved);
  EXPECT_GT((moved.shapes.back().p_W - p).norm(), 0.05);
}

// Rays in all directions at once, and from within a link.
TEST(PosedBody, RaysNeedNotBeNeighbours) {
  World world(kArm, nullptr, {});
  world.set_state(working_posture(), JointVector::Zero(7));
  PosedBody body;
  world.copy_body(&body);
  std::mt19937 random(2);
  for (const Vector3d& eye : {Vector3d(0.4, 0.1, 0.5), Vector3d(0.0, 0.0, 0.1)}) {
    std::vector<Vector3d> directions;
    for (int i = 0; i < 200; ++i)
      directions.push_back(Vector3d(random_vector(random, 7, 1.0).head<3>()).normalized());
    std::vector<double> distances(directions.size(), std::numeric_limits<double>::infinity());
    body.cover(eye, directions, distances, PosedBody::Rays::all);
    for (std::size_t i = 0; i < directions.size(); ++i)
      ASSERT_EQ(distances[i], world.ray_to_arm(eye, directions[i]));
  }
}

}  // namespace
}  // namespace impedraw

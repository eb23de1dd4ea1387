#include "impedraw/common/rotations.h"

#include <random>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

// Against Eigen's, and for opposite directions, where any axis across will do.
TEST(TurnBetween, TakesOneDirectionToTheOther) {
  const unsigned seed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto vector = [&] {
    return Eigen::Vector3d(normal(random), normal(random), normal(random));
  };
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d a = vector();
    const Eigen::Vector3d b = i % 4 == 0 ? Eigen::Vector3d(-2.0 * a + 1e-2 * vector()) : vector();
    const Eigen::Quaterniond turn = turn_between(a, b);
    EXPECT_LT((turn * a.normalized() - b.normalized()).norm(), 1e-7);
    EXPECT_LT(turn.angularDistance(Eigen::Quaterniond::FromTwoVectors(a, b)), 1e-7);
  }
  const Eigen::Vector3d a = vector();
  const Eigen::Quaterniond half = turn_between(a, -3.0 * a);
  EXPECT_LT((half * a + a).norm(), 1e-12);
  EXPECT_NEAR(half.norm(), 1.0, 1e-12);
}

}  // namespace
}  // namespace impedraw

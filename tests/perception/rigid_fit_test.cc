// The fit against motions that are known, its covariance against a Monte Carlo run.
#include "impedraw/perception/rigid_fit.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

namespace impedraw {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Pose random_pose(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  return {vector(), Eigen::AngleAxisd(normal(random), vector().normalized()).toRotationMatrix()};
}

TEST(RigidFit, FindsAnyMotionFromThreeMarksOn) {
  const unsigned seed = 20261123;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 0.2);
  for (int trial = 0; trial < 200; ++trial) {
    const Pose X_WK = random_pose(random);
    std::vector<Vector3d> p_K, p_W;
    for (int i = 0; i < 3 + trial % 4; ++i) {
      p_K.emplace_back(normal(random), normal(random), normal(random));
      p_W.push_back(X_WK * p_K.back());
    }
    const RigidFit fit = fit_rigid(p_K, p_W);
    EXPECT_LT((fit.X_WK.R - X_WK.R).norm(), 1e-9) << trial;
    EXPECT_LT((fit.X_WK.p - X_WK.p).norm(), 1e-9) << trial;
  }
}

TEST(RigidFit, TellsTheErrorsThatNoiseMakes) {
  constexpr double kNoise = 1e-3;
  constexpr int kTrials = 20000;
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, kNoise);
  const Pose X_WK = random_pose(random);
  const std::vector<Vector3d> p_K = {{0.2, 0, 0}, {0, 0.15, 0.02}, {-0.1, 0, 0}, {0, -0.2, 0.05}};
  Matrix3d turn = Matrix3d::Zero(), shift = Matrix3d::Zero();
  RigidFit fit;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<Vector3d> p_W;
    for (const Vector3d& p : p_K)
      p_W.push_back(X_WK * p + Vector3d(normal(random), normal(random), normal(random)));
    fit = fit_rigid(p_K, p_W);
    const Eigen::AngleAxisd off(Matrix3d(fit.X_WK.R * X_WK.R.transpose()));
    const Vector3d phi = off.angle() * off.axis();
    const Vector3d moved = fit.X_WK * fit.centre_K - X_WK * fit.centre_K;
    turn += phi * phi.transpose() / kTrials;
    shift += moved * moved.transpose() / kTrials;
  }
  const double variance = kNoise * kNoise;
  EXPECT_LT((turn - variance * fit.rotation_covariance).norm(), 0.04 * turn.norm());
  EXPECT_LT((shift - variance * fit.position_variance * Matrix3d::Identity()).norm(),
            0.04 * shift.norm());
}

TEST(RigidFit, KnowsHowFarMarksLieBesideALine) {
  const std::vector<Vector3d> line = {{0, 0, 0}, {1, 1, 1}, {3, 3, 3}},
                              pair = {{0, 0, 0}, {1, 0, 0}},
                              cross = {{1, 0, 0}, {-1, 0, 0}, {0, 0.1, 0}, {0, -0.1, 0}};
  EXPECT_LT(spread_beside_line(line), 1e-6);
  EXPECT_EQ(spread_beside_line(pair), 0.0);
  EXPECT_NEAR(spread_beside_line(cross), 0.1 / std::sqrt(2.0), 1e-12);
}

}  // namespace
}  // namespace impedraw

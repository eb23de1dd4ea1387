#include "impedraw/perception/neighbours.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <unordered_set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "impedraw/perception/cube_set.h"
#include "impedraw/perception/normals.h"
#include "impedraw/perception/recent_neighbours.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

// A wavy sheet whose density varies by a factor of 30, with a hole.
std::vector<Vector3d> sheet(unsigned seed, int n) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Vector3d> points;
  while (int(points.size()) < n) {
    const double x = 0.2 * std::pow(uniform(random), 2), y = 0.2 * uniform(random);
    if (std::hypot(x - 0.1, y - 0.1) < 0.02) continue;
    points.emplace_back(x, y, 0.01 * std::sin(40 * x));
  }
  return points;
}

TEST(Neighbours, AreThoseOfBruteForce) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    const auto points = sheet(seed, 3000);
    const NeighbourTree tree(points);
    std::mt19937 random(seed + 100);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const int k : {1, 8, 40, kMostNeighbours}) {
      std::vector<double> reach2(points.size());
      std::vector<int> index(k);
      std::vector<double> squared(k);
      for (std::size_t i = 0; i < points.size(); ++i) {
        tree.nearest(points[i], k, 1, index.data(), squared.data());
        reach2[i] = squared[k - 1];
      }
      for (int q = 0; q < 300; ++q) {
        // In the sheet, above it, beyond its edge, in the hole.
        const Vector3d p(0.25 * uniform(random), 0.25 * uniform(random),
                         0.03 * uniform(random) * (q % 3));
        const double max_radius = q % 2 ? 1.0 : 0.02;
        std::vector<double> brute;
        for (const auto& point : points) {
          const double d2 = (point - p).squaredNorm();
          if (d2 < max_radius * max_radius) brute.push_back(d2);
        }
        std::sort(brute.begin(), brute.end());
        brute.resize(std::min<std::size_t>(brute.size(), k));

        const auto expect_same = [&](int n) {
          ASSERT_EQ(n, int(brute.size()));
          for (int i = 0; i < n; ++i) EXPECT_EQ((points[index[i]] - p).squaredNorm(), squared[i]);
          if (n == k) {
            EXPECT_DOUBLE_EQ(squared[k - 1], brute[k - 1]);  // the furthest comes last
          }
          std::vector<double> sorted(squared.begin(), squared.begin() + n);
          std::sort(sorted.begin(), sorted.end());
          for (int i = 0; i < n; ++i) EXPECT_DOUBLE_EQ(sorted[i], brute[i]);
        };
        const int n = tree.nearest(p, k, max_radius, index.data(), squared.data());
        expect_same(n);
        EXPECT_TRUE(std::is_sorted(squared.begin(), squared.begin() + n));
        int closest = -2;
        const int m = tree.nearest_unordered(p, k, max_radius, reach2, index.data(), squared.data(),
                                             &closest);
        expect_same(m);
        if (m == k) {
          ASSERT_GE(closest, 0);
          EXPECT_EQ((points[closest] - p).squaredNorm(), brute.front());
        }
        const double middle = n > 1 ? std::sqrt(0.5 * (brute[n / 2 - 1] + brute[n / 2])) : 1e-6;
        EXPECT_TRUE(n < 2 || tree.has_within(p, middle, n / 2));
        EXPECT_FALSE(tree.has_within(p, middle, n / 2 + 1));
      }
    }
  }
}

TEST(Neighbours, GuessOfAnySizeGivesTheSamePoints) {
  const auto points = sheet(9, 2000);
  const NeighbourTree tree(points);
  int index[40], closest;
  double right[40], squared[40];
  for (const double guess :
       {0.0, 1e-6, 1e-4, 1.0}) {  // too small: falls back; too large: more than there is room for
    const std::vector<double> reach2(points.size(), guess);
    for (double x = 0; x < 0.2; x += 0.01) {
      tree.nearest({x, 0.1, 0}, 40, 1, index, right);
      ASSERT_EQ(tree.nearest_unordered({x, 0.1, 0}, 40, 1, reach2, index, squared, &closest), 40);
      std::sort(squared, squared + 40);
      EXPECT_TRUE(std::equal(squared, squared + 40, right));
      ASSERT_EQ(tree.nearest({x, 0.1, 0}, 40, 1, index, squared, guess), 40);
      EXPECT_TRUE(std::equal(squared, squared + 40, right));
    }
  }
}

// Along a path that now and then jumps, over a grid, too, where many points are equally far.
TEST(RecentNeighbours, AreThoseOfTheTree) {
  std::vector<Vector3d> grid;
  for (int i = 0; i < 1600; ++i) grid.emplace_back(0.005 * (i % 40), 0.005 * (i / 40), 0.0);
  for (const std::vector<Vector3d>& points : {grid, sheet(1, 3000), sheet(2, 300)}) {
    const NeighbourTree tree(points);
    RecentNeighbours recent;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(0, 1);
    Vector3d p(0.1, 0.05, 0.0);
    int index[kMostNeighbours], expected_index[kMostNeighbours];
    double squared[kMostNeighbours], expected[kMostNeighbours];
    for (int q = 0; q < 3000; ++q) {
      const double step = q % 50 == 0 ? 0.05 : q % 7 == 0 ? 0.004 : 2e-4;
      p += step *
           Vector3d(uniform(random) - 0.4, uniform(random) - 0.5, 0.2 * uniform(random) - 0.1);
      if (p.head<2>().norm() > 0.4) p = Vector3d(0.1, 0.05, 0.0);
      const int k = std::vector<int>{60, 13, 60, kMostNeighbours, 1}[q / 20 % 5];
      const double max_radius = q / 100 % 3 == 0 ? 0.01 : 0.06;
      const int n = tree.nearest(p, k, max_radius, expected_index, expected);
      ASSERT_EQ(recent.nearest(tree, points, p, k, max_radius, index, squared), n) << q;
      for (int i = 0; i < n; ++i) {
        ASSERT_EQ(squared[i], expected[i]) << q;
        ASSERT_EQ((points[index[i]] - p).squaredNorm(), squared[i]) << q;
      }
    }
  }
}

// Over ground that asks for finer clouds in part.
TEST(RecentNeighbours, GiveTheSameSurface) {
  const auto cloud_of = [](double spacing) {
    PointCloud cloud;
    cloud.eyes.emplace_back(0.1, 0.05, 0.8);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-0.2, 0.2);
    for (double x = 0.0; x < 0.2; x += spacing)
      for (double y = 0.0; y < 0.1; y += spacing) {
        const double u = x + spacing * uniform(random), v = y + spacing * uniform(random);
        cloud.points.emplace_back(u, v, u < 0.1 ? 0.0 : 2e-3 * std::sin(300.0 * u));
        cloud.camera.push_back(0);
      }
    return cloud;
  };
  FinerClouds finer{cloud_of(2e-3), cloud_of(1e-3)};
  const SurfaceEstimator surface(cloud_of(4e-3), {}, std::move(finer));
  RecentSurface recent;
  int fine = 0;
  for (int i = 0; i < 1500; ++i) {
    const Vector3d p(0.02 + 1e-4 * i, 0.05 + 0.02 * std::sin(0.01 * i), 1e-3 * std::sin(0.1 * i));
    const SurfaceEstimate expected = surface.estimate(p), found = surface.estimate(p, &recent);
    fine += surface.finer_share(p) > 0.5;
    ASSERT_EQ(found.status, expected.status) << i;
    if (found.status != SurfaceStatus::ok) continue;
    EXPECT_LT((found.n_W - expected.n_W).norm(), 1e-9) << i;
    EXPECT_NEAR(found.distance, expected.distance, 1e-12) << i;
  }
  EXPECT_GT(fine, 100);
  EXPECT_LT(fine, 1400);
  // What one knows of its own points is what it answers there.
  ASSERT_EQ(surface.at_points().size(), surface.cloud().points.size());
  for (std::size_t i = 0; i < surface.at_points().size(); ++i) {
    const SurfaceEstimate &known = surface.at_points()[i],
                          asked = surface.estimate(surface.cloud().points[i]);
    ASSERT_EQ(known.status, asked.status) << i;
    if (known.status != SurfaceStatus::ok) continue;
    EXPECT_LT((known.n_W - asked.n_W).norm(), 1e-9) << i;
    EXPECT_NEAR(known.distance, asked.distance, 1e-12) << i;
  }
}

TEST(CubeSet, HasWhatWasPutIn) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  CubeSet set;
  std::unordered_set<std::uint64_t> expected;
  for (int i = 0; i < 20000; ++i) {
    const Vector3d p(0.05 * uniform(random), 0.05 * uniform(random), 0.002 * uniform(random));
    const std::uint64_t cube = cube_of(p, 1e-3);
    EXPECT_EQ(set.insert(cube), expected.insert(cube).second);
    const std::uint64_t other = cube_of(2.0 * p, 1e-3);
    EXPECT_EQ(set.contains(other), expected.contains(other));
  }
  // Middles of cubes are multiples of the side, below zero, too.
  EXPECT_EQ(cube_of({-4.9e-4, 4.9e-4, -1e-3}, 1e-3), cube_of({4.9e-4, -4.9e-4, -1.4e-3}, 1e-3));
  EXPECT_NE(cube_of({-5.1e-4, 0, 0}, 1e-3), cube_of({0, 0, 0}, 1e-3));
}

TEST(Neighbours, TreeOrderIsAPermutation) {
  const auto points = sheet(4, 777);
  std::vector<int> order = tree_order(points);
  std::sort(order.begin(), order.end());
  for (int i = 0; i < 777; ++i) EXPECT_EQ(order[i], i);
}

}  // namespace
}  // namespace impedraw

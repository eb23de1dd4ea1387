#include "impedraw/perception/plan_surface.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

double angle_deg(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

// Points of z = f(x, y) over a square of half side `half`, on a jittered grid of the given spacing,
// seen from the eye.
PointCloud sheet(double half, double spacing, const std::function<double(double, double)>& f,
                 const Vector3d& eye = {0, 0, 1}, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-0.4, 0.4);
  PointCloud cloud;
  cloud.eyes.push_back(eye);
  const int n = int(half / spacing);
  for (int i = -n; i <= n; ++i) {
    for (int j = -n; j <= n; ++j) {
      const double x = (i + uniform(random)) * spacing, y = (j + uniform(random)) * spacing;
      cloud.points.emplace_back(x, y, f(x, y));
      cloud.camera.push_back(0);
    }
  }
  return cloud;
}

const auto kFlat = [](double, double) { return 0.0; };

std::vector<NormalSettings> every_way() {
  std::vector<NormalSettings> all;
  for (const auto weighting : {NeighbourWeighting::uniform, NeighbourWeighting::smooth}) {
    for (const auto fit : {SurfaceFit::plane, SurfaceFit::quadric})
      all.push_back({.weighting = weighting, .fit = fit});
  }
  return all;
}

TEST(Normals, TiltedPlaneIsExactEachWay) {
  const Vector3d n = Vector3d(-0.3, 0.5, 1).normalized();
  const PointCloud cloud = sheet(0.08, 0.003, [](double x, double y) { return 0.3 * x - 0.5 * y; });
  for (const auto& settings : every_way()) {
    const SurfaceEstimator estimator(cloud, settings);
    for (const double h : {-0.004, 0.0, 0.001, 0.02}) {
      for (double x = -0.03; x <= 0.03; x += 0.0073) {
        const SurfaceEstimate e = estimator.estimate(Vector3d(x, 0.01, 0.3 * x - 0.005) + h * n);
        ASSERT_EQ(e.status, SurfaceStatus::ok);
        EXPECT_LT((e.n_W - n).norm(), 1e-7);
        EXPECT_NEAR(e.distance, h, 1e-12);
      }
    }
  }
}

TEST(Normals, TurnTowardsTheCameraThatSawThem) {
  const PointCloud above = sheet(0.05, 0.003, kFlat, {0.3, 0, 1});
  const PointCloud below = sheet(0.05, 0.003, kFlat, {0.3, 0, -1});
  for (const auto& settings : every_way()) {
    const SurfaceEstimate a = SurfaceEstimator(above, settings).estimate({0, 0, 0.002});
    EXPECT_GT(a.n_W.z(), 0.999);
    EXPECT_NEAR(a.distance, 0.002, 1e-12);
    const SurfaceEstimate b = SurfaceEstimator(below, settings).estimate({0, 0, 0.002});
    EXPECT_LT(b.n_W.z(), -0.999);
    EXPECT_NEAR(b.distance, -0.002, 1e-12);
  }
  const SurfaceEstimator estimator(below);
  for (std::size_t i = 0; i < estimator.cloud().points.size(); ++i) {
    const Vector3d& n = estimator.cloud().normals[i];
    EXPECT_TRUE(n.z() < -0.999 || !n.allFinite());
  }
}

TEST(Normals, CylinderAndSaddleMatchTheirClosedForms) {
  // A groove of radius R 30° from x, and a saddle of that curvature: what a fit of the mean
  // curvature alone would miss.
  const double R = 0.1, c = std::cos(std::numbers::pi / 6), s = 0.5;
  const PointCloud groove = sheet(0.06, 0.003, [&](double x, double y) {
    return R - std::sqrt(R * R - std::pow(-s * x + c * y, 2));
  });
  const SurfaceEstimator estimator(groove, {.k = 40});
  for (double t = -0.03; t <= 0.03; t += 0.0011) {
    const Vector3d across(-s, c, 0), along(c, s, 0);
    const Vector3d n =
        Vector3d(0, 0, R) - across * t - Vector3d(0, 0, R - std::sqrt(R * R - t * t));
    const Vector3d on = across * t + Vector3d(0, 0, R - std::sqrt(R * R - t * t)) + along * 0.2 * t;
    const SurfaceEstimate e = estimator.estimate(on + 0.001 * n.normalized());
    ASSERT_EQ(e.status, SurfaceStatus::ok);
    EXPECT_LT(angle_deg(e.n_W, n), 0.1);
    EXPECT_NEAR(e.distance, 0.001, 1e-5);
  }
  const auto saddle = [](double x, double y) { return 5 * (x * x - y * y); };
  const SurfaceEstimator on_saddle(sheet(0.06, 0.003, saddle), {.k = 40});
  for (double x = -0.03; x <= 0.03; x += 0.007) {
    for (double y = -0.03; y <= 0.03; y += 0.007) {
      const Vector3d n = Vector3d(-10 * x, 10 * y, 1).normalized();
      for (const double h : {0.0, 0.001, 0.01}) {
        const SurfaceEstimate e = on_saddle.estimate(Vector3d(x, y, saddle(x, y)) + h * n);
        ASSERT_EQ(e.status, SurfaceStatus::ok);
        EXPECT_LT(angle_deg(e.n_W, n), 0.15);
        EXPECT_NEAR(e.distance, h, 2e-5);
      }
    }
  }
}

TEST(Normals, UniformPlaneIsThePapersEquation) {
  const PointCloud cloud =
      sheet(0.06, 0.003, [](double x, double y) { return 4 * x * x + 2 * x * y + 0.2 * y; });
  const int k = 33;
  const SurfaceEstimator estimator(
      cloud, {.k = k, .weighting = NeighbourWeighting::uniform, .fit = SurfaceFit::plane});
  for (const unsigned seed : {1u, 2u}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-0.03, 0.03);
    for (int q = 0; q < 100; ++q) {
      const Vector3d p(uniform(random), uniform(random), 0.005);
      std::vector<Vector3d> points = cloud.points;
      std::sort(points.begin(), points.end(), [&](const Vector3d& a, const Vector3d& b) {
        return (a - p).norm() < (b - p).norm();
      });
      Vector3d mean = Vector3d::Zero();
      for (int i = 0; i < k; ++i) mean += points[i] / k;
      Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
      for (int i = 0; i < k; ++i)
        covariance += (points[i] - mean) * (points[i] - mean).transpose() / k;
      Vector3d n = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance)
                       .eigenvectors()
                       .col(0);  // iterative, not closed form
      if (n.z() < 0) n = -n;
      const SurfaceEstimate e = estimator.estimate(p);
      ASSERT_EQ(e.status, SurfaceStatus::ok);
      EXPECT_LT((e.n_W - n).norm(), 1e-7);
      EXPECT_NEAR(e.distance, n.dot(p - mean), 1e-9);
    }
  }
}

TEST(Normals, DoNotJumpAsTheTipSlides) {
  const PointCloud cloud =
      sheet(0.05, 0.003, [](double x, double y) { return 3 * x * x + 3 * y * y; });
  const auto largest_step_deg = [&](NormalSettings settings) {
    const SurfaceEstimator estimator(cloud, settings);
    double largest = 0;
    Vector3d last = Vector3d::Zero();
    for (int i = 0; i <= 20000; ++i) {
      const double x = -0.02 + 2e-6 * i;  // 2 µm a step; the surface itself turns 0.0007° in it
      const SurfaceEstimate e = estimator.estimate({x, 0.3 * x, 3 * x * x * 1.09});
      if (i > 0) largest = std::max(largest, angle_deg(e.n_W, last));
      last = e.n_W;
    }
    return largest;
  };
  EXPECT_LT(largest_step_deg({}), 0.0015);
  EXPECT_LT(largest_step_deg({.fit = SurfaceFit::plane}), 0.003);
  EXPECT_GT(largest_step_deg({.weighting = NeighbourWeighting::uniform, .fit = SurfaceFit::plane}),
            0.01);  // the paper's jumps
}

TEST(Normals, StandardDeviationUnderNoiseFollowsTheory) {
  // A plane z = Σ slope fitted by k equal weights over a patch of radius r: slope's σ = σ_z /
  // sqrt(k r²/4), r² = k spacing²/π.
  const double spacing = 0.004, sigma = 0.0003;
  const int k = 60;
  double sum2 = 0;
  int n = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, sigma);
    const SurfaceEstimator estimator(
        sheet(
            0.15, spacing, [&](double, double) { return noise(random); }, {0, 0, 1}, seed),
        {.k = k, .weighting = NeighbourWeighting::uniform, .fit = SurfaceFit::plane});
    for (double x = -0.1; x <= 0.1; x += 0.025) {
      for (double y = -0.1; y <= 0.1; y += 0.025) {
        const SurfaceEstimate e = estimator.estimate({x, y, 0});
        ASSERT_EQ(e.status, SurfaceStatus::ok);
        sum2 += e.n_W.head<2>().squaredNorm();
        n += 2;
      }
    }
  }
  const double expected = sigma / std::sqrt(k * k * spacing * spacing / (4 * std::numbers::pi));
  EXPECT_NEAR(std::sqrt(sum2 / n), expected, 0.06 * expected) << "seeds 1 to 10";
}

TEST(Normals, WeighPointsByThePixelsBehindThem) {
  PointCloud cloud = sheet(0.05, 0.003, kFlat);
  cloud.weight.assign(cloud.points.size(), 10.0);
  for (std::size_t i = 0; i < cloud.points.size(); i += 5) {  // strays: one pixel each, 1 mm off
    cloud.points[i].z() = 0.001;
    cloud.weight[i] = 1.0;
  }
  PointCloud unweighted = cloud;
  unweighted.weight.clear();
  const NormalSettings settings{.fit = SurfaceFit::plane};
  EXPECT_NEAR(SurfaceEstimator(cloud, settings).estimate({0, 0, 0}).distance, -0.001 / 41, 1.2e-5);
  EXPECT_NEAR(SurfaceEstimator(unweighted, settings).estimate({0, 0, 0}).distance, -0.001 / 5,
              5e-5);
}

PlanSurface plan_over(PointCloud cloud, FinerClouds finer, double max_one_sidedness = 0.5,
                      double most_misfit = Roughness::kStepMisfit) {
  return PlanSurface(std::make_shared<const SurfaceEstimator>(std::move(cloud), NormalSettings(),
                                                              std::move(finer)),
                     max_one_sidedness, most_misfit);
}

// A plan's patch, 15 mm wide, reaches over a step of the surface 6 mm away. Weights that fall with
// the distance alone leave the normal 10 degrees off and more.
TEST(Normals, APlansPatchKeepsToOneSideOfAStep) {
  for (const double step : {0.01, 0.02, 0.05}) {
    const auto stepped = [&](double x, double) { return x < 0.0 ? 0.1 * x + step : 0.1 * x; };
    FinerClouds finer;
    for (const double spacing : {0.002, 0.001}) finer.push_back(sheet(0.03, spacing, stepped));
    const PlanSurface plan = plan_over(sheet(0.06, 0.004, stepped), std::move(finer), 0.66);
    const Vector3d n = Vector3d(-0.1, 0, 1).normalized();
    for (const double x : {-0.012, -0.008, -0.006, 0.006, 0.008, 0.012}) {
      const SurfaceEstimate e = plan.estimate({x, 0.002, stepped(x, 0)});
      ASSERT_EQ(e.status, SurfaceStatus::ok) << x;
      EXPECT_LT(angle_deg(e.n_W, n), 1.0) << "step " << step << " x " << x;
      EXPECT_LT(std::abs(e.distance), 1e-4) << "step " << step << " x " << x;
    }
  }
}

// On rough ground a wide patch leaves more than an edge does: 22 and 7 of 36 places on an edge were
// promised. Where the ground alone is rough, all of it may be drawn on.
TEST(Normals, APlanKeepsOffAnEdgeOverRoughGround) {
  for (const double step : {0.0, 1.5e-3, 2.5e-3}) {
    const auto ground = [step](double x, double y) {
      const double k = 2.0 * std::numbers::pi / 0.018;
      return 0.25 / k * (std::sin(k * x + 1.0) + std::sin(k * (0.6 * x + 0.8 * y))) +
             (x < 0.002 * std::sin(150.0 * y) ? step : 0.0);
    };
    FinerClouds finer;
    for (const double spacing : {2e-3, 1e-3}) finer.push_back(sheet(0.05, spacing, ground));
    const PlanSurface plan = plan_over(sheet(0.05, 4e-3, ground), std::move(finer), 0.66, 2e-4);
    int promised = 0, places = 0, off = 0;
    for (double y = -0.03; y < 0.03; y += 1.7e-3, ++places) {
      const double edge = 0.002 * std::sin(150.0 * y);
      promised += plan.estimate({edge, y, ground(edge, y)}).status == SurfaceStatus::ok;
      for (const double x : {-0.025, -0.015, 0.015, 0.025})
        off += plan.estimate({x, y, ground(x, y)}).status != SurfaceStatus::ok;
    }
    if (step > 0.0) {
      EXPECT_LE(promised, places / 6) << step;
    } else {
      EXPECT_EQ(promised, places);
    }
    EXPECT_EQ(off, 0) << step;
  }
}

// z = |x| tan(half of the angle): a valley whose sides meet at that angle; negative: a ridge.
PlanSurface plan_over_valley(double angle_deg) {
  const double rise = std::tan(angle_deg / 2.0 * std::numbers::pi / 180.0);
  const auto valley = [rise](double x, double) { return rise * std::abs(x); };
  FinerClouds finer;
  for (const double spacing : {2e-3, 1e-3}) finer.push_back(sheet(0.04, spacing, valley));
  return plan_over(sheet(0.04, 4e-3, valley), std::move(finer));
}

TEST(Normals, APlanKeepsOffCreasesAndOffNothingElse) {
  for (const double angle : {75.0, 100.0}) {
    SCOPED_TRACE(angle);
    const double rise = std::tan(angle / 2.0 * std::numbers::pi / 180.0);
    const PlanSurface plan = plan_over_valley(angle);
    for (const double y : {-0.01, 0.0, 0.012}) {
      EXPECT_TRUE(plan.in_crease({0, y, 0}));
      EXPECT_NE(plan.estimate({0, y, 0}).status, SurfaceStatus::ok);
      EXPECT_FALSE(plan.in_crease({0.015, y, 0.015 * rise}));
      EXPECT_EQ(plan.estimate({0.015, y, 0.015 * rise}).status, SurfaceStatus::ok);
    }
  }
  for (const double angle : {0.0, 25.0, 45.0, -75.0, -100.0}) {
    SCOPED_TRACE(angle);
    const PlanSurface plan = plan_over_valley(angle);
    for (const double y : {-0.01, 0.0, 0.012}) EXPECT_FALSE(plan.in_crease({0, y, 0}));
  }
}

// Waves of 15 mm, up to 40° steep: cameras resolve them, and the tip fits into their valleys,
// though places 9 mm apart lean towards each other by up to 77°.
TEST(Normals, ResolvedWavesAreNoCreases) {
  const double k = 2.0 * std::numbers::pi / 0.015,
               a = std::tan(40.0 * std::numbers::pi / 180.0) / k;
  const auto waves = [=](double x, double y) {
    return a * std::sin(k * x) * std::cos(0.3 * k * y);
  };
  FinerClouds finer;
  for (const double spacing : {2e-3, 1e-3}) finer.push_back(sheet(0.04, spacing, waves));
  const PlanSurface plan = plan_over(sheet(0.04, 4e-3, waves), std::move(finer));
  int creases = 0, places = 0;
  for (double x = -0.025; x < 0.025; x += 1e-3)
    for (double y = -0.025; y < 0.025; y += 5e-3, ++places)
      creases += plan.in_crease({x, y, waves(x, y)});
  EXPECT_LT(creases, places / 50);
}

// Waves of 20 mm that rise from nothing to 3 mm. A plan changes from the widest patches to finer
// ones between 0.5 and 1.5 mm of difference, so that it is at most 0.5625 mm off the finer ones.
TEST(Normals, APlanUsesFinerPatchesWhereverTheyTellMore) {
  const double k = 2.0 * std::numbers::pi / 0.02;
  const auto waves = [k](double x, double y) {
    return 0.05 * std::max(0.0, x + 0.02) * std::sin(k * x) * std::cos(0.5 * k * y);
  };
  FinerClouds finer;
  for (const double spacing : {2e-3, 1e-3}) finer.push_back(sheet(0.06, spacing, waves));
  const PointCloud cloud = sheet(0.06, 4e-3, waves);
  const SurfaceEstimator widest(cloud);
  const PlanSurface plan = plan_over(cloud, std::move(finer), NormalSettings().max_one_sidedness);
  int apart = 0, places = 0;
  for (double x = -0.045; x < 0.045; x += 1.1e-3)
    for (double y = -0.045; y < 0.045; y += 3.1e-3) {
      const Vector3d p(x, y, waves(x, y) + 8e-4 * std::sin(1e5 * (x + y)));
      const SurfaceEstimate e = plan.estimate(p), fine = plan.seen().estimate(p);
      if (e.status != SurfaceStatus::ok) continue;
      EXPECT_LT(std::abs(e.distance - fine.distance), 5.63e-4) << x << " " << y;
      apart += std::abs(widest.estimate(p).distance - fine.distance) > 7e-4;
      ++places;
    }
  EXPECT_GT(places, 1500);
  EXPECT_GT(apart, places / 20);
  EXPECT_LT(apart, places / 2);
}

// In the middle of a hole the fit around it still tells a surface, 9 mm from the nearest point.
TEST(Normals, APlansSurfaceDoesNotRunOnBeyondItsPoints) {
  PointCloud cloud = sheet(0.06, 4e-3, kFlat);
  const auto in_hole = [](const Vector3d& p) { return p.head<2>().norm() < 9e-3; };
  cloud.points.erase(std::remove_if(cloud.points.begin(), cloud.points.end(), in_hole),
                     cloud.points.end());
  cloud.camera.resize(cloud.points.size());
  const PlanSurface plan = plan_over(std::move(cloud), {});
  EXPECT_EQ(plan.seen().estimate(Vector3d::Zero()).status, SurfaceStatus::ok);
  EXPECT_EQ(plan.estimate(Vector3d::Zero()).status, SurfaceStatus::off_edge);
  EXPECT_EQ(plan.estimate({0.03, 0, 0}).status, SurfaceStatus::ok);
}

// A hole of 5.4 mm, wherever it lies between the points of the cloud, which are 4 mm apart.
TEST(Normals, APlanKeepsOffAHoleOnAllSidesOfIt) {
  for (const Vector3d& middle :
       {Vector3d(0, 0, 0), Vector3d(1e-3, 2e-3, 0), Vector3d(-2e-3, 0.5e-3, 0)}) {
    const auto drilled = [&](double spacing) {
      PointCloud cloud = sheet(0.04, spacing, kFlat);
      std::erase_if(cloud.points, [&](const Vector3d& p) { return (p - middle).norm() < 2.7e-3; });
      cloud.camera.resize(cloud.points.size());
      return cloud;
    };
    FinerClouds finer;
    for (const double spacing : {2e-3, 1e-3}) finer.push_back(drilled(spacing));
    const PlanSurface plan = plan_over(drilled(4e-3), std::move(finer));
    for (int k = 0; k < 24; ++k) {
      const double angle = k * std::numbers::pi / 12.0;
      const Vector3d out(std::cos(angle), std::sin(angle), 0.0);
      for (const double r : {0.0, 1e-3, 2e-3, 3e-3, 4e-3})
        EXPECT_EQ(plan.estimate(middle + r * out).status, SurfaceStatus::off_edge)
            << "middle " << middle.transpose() << ", " << r << " m off it, " << k;
      EXPECT_EQ(plan.estimate(middle + 8e-3 * out).status, SurfaceStatus::ok) << k;
    }
  }
}

// The tangent planes of the lower sheet run on below the upper one.
TEST(Normals, APlanFindsNoHoleUnderAnUpperSheet) {
  const auto stepped = [](double x, double) { return x < 0.0 ? 4e-3 : 0.0; };
  FinerClouds finer;
  for (const double spacing : {2e-3, 1e-3}) finer.push_back(sheet(0.04, spacing, stepped));
  const PlanSurface plan = plan_over(sheet(0.04, 4e-3, stepped), std::move(finer), 0.66);
  for (const double x : {-6.5e-3, 6.5e-3})
    for (double y = -0.012; y < 0.012; y += 1.3e-3)
      EXPECT_EQ(plan.estimate({x, y, stepped(x, y)}).status, SurfaceStatus::ok) << x << " " << y;
}

TEST(Normals, TooFewWithinReach) {
  const PointCloud cloud = sheet(0.05, 0.003, kFlat);
  for (const auto& way : every_way()) {
    NormalSettings settings = way;
    settings.max_radius = 0.02;
    const SurfaceEstimator estimator(cloud, settings);
    EXPECT_EQ(estimator.estimate({0, 0, 0.001}).status, SurfaceStatus::ok);
    EXPECT_EQ(estimator.estimate({0, 0, 0.021}).status, SurfaceStatus::too_few);
    EXPECT_EQ(estimator.estimate({0.2, 0, 0}).status, SurfaceStatus::too_few);
    EXPECT_EQ(estimator.estimate({std::nan(""), 0, 0}).status, SurfaceStatus::too_few);
  }
  PointCloud few = cloud;
  few.points.resize(40);
  few.camera.resize(40);
  EXPECT_EQ(SurfaceEstimator(few, {.k = 60}).estimate(few.points[20]).status,
            SurfaceStatus::too_few);
}

TEST(Normals, PointsInALineOrABallAreNoSurface) {
  PointCloud line, ball, one;
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0, 0.01);
  for (int i = 0; i < 500; ++i) {
    line.points.emplace_back(0.0001 * i, 0, 0);
    ball.points.emplace_back(normal(random), normal(random), normal(random));
    one.points.emplace_back(0.01, 0, 0);
  }
  for (PointCloud* cloud : {&line, &ball, &one}) {
    cloud->camera.assign(500, 0);
    cloud->eyes.push_back({0, 0, 1});
    for (const auto& settings : every_way()) {
      EXPECT_EQ(SurfaceEstimator(*cloud, settings).estimate({0.02, 0, 0.001}).status,
                SurfaceStatus::too_few);
      if (cloud != &ball) continue;
      EXPECT_EQ(SurfaceEstimator(*cloud, settings).estimate({0, 0, 0}).status,
                SurfaceStatus::too_few);
    }
  }
}

// From within a straight edge outward: good until the edge, off_edge soon beyond it, never a wild
// normal on the way.
TEST(Normals, OffTheEdgeIsAStatus) {
  const double spacing = 0.003;
  const auto bowl = [](double x, double y) { return 0.3 - std::sqrt(0.09 - x * x - y * y); };
  PointCloud cloud;
  const PointCloud whole = sheet(0.06, spacing, bowl);
  cloud.eyes = whole.eyes;
  for (const auto& p : whole.points) {
    if (p.x() > 0.02) continue;
    cloud.points.push_back(p);
    cloud.camera.push_back(0);
  }
  for (const auto& settings : every_way()) {
    const SurfaceEstimator estimator(cloud, settings);
    const double patch = std::sqrt(settings.k / std::numbers::pi) * spacing;
    for (double y = -0.03; y <= 0.03; y += 0.0017) {
      double last_ok = -1;
      for (double x = 0; x < 0.055; x += 0.0002) {
        const SurfaceEstimate e = estimator.estimate({x, y, bowl(x, y)});
        if (e.status != SurfaceStatus::ok) continue;
        last_ok = x;
        EXPECT_LT(angle_deg(e.n_W, Vector3d(-x, -y, std::sqrt(0.09 - x * x - y * y))),
                  settings.fit == SurfaceFit::plane ? 2.5 : 0.2);
      }
      EXPECT_GT(last_ok, 0.02 - spacing);
      EXPECT_LT(last_ok, 0.02 + spacing + 0.2 * patch);
    }
  }
}

TEST(Normals, RefuseBadSettingsByName) {
  const auto expect_refused = [](const PointCloud& cloud, const NormalSettings& settings,
                                 const std::string& what) {
    try {
      SurfaceEstimator estimator(cloud, settings);
      ADD_FAILURE() << "accepted, though " << what;
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr(what));
    }
  };
  PointCloud cloud = sheet(0.02, 0.003, kFlat);
  EXPECT_NO_THROW(SurfaceEstimator{cloud});
  expect_refused(cloud, {.k = 7}, "normals.k is 7, allowed is 8 to 128");
  expect_refused(cloud, {.k = 129}, "normals.k is 129");
  expect_refused(cloud, {.max_radius = std::nan("")}, "normals.max_radius is nan m");
  expect_refused(cloud, {.max_one_sidedness = 1.5}, "normals.max_one_sidedness is 1.5");
  expect_refused({}, {}, "no points");
  PointCloud broken = cloud;
  broken.camera[3] = 1;
  expect_refused(broken, {}, "point 3 of the cloud names camera 1");
  broken = cloud;
  broken.points[5].z() = std::nan("");
  expect_refused(broken, {}, "point 5 of the cloud is not finite");
  broken = cloud;
  broken.camera.pop_back();
  expect_refused(broken, {}, "camera indices");
  broken = cloud;
  broken.weight.assign(cloud.points.size(), 1.0);
  broken.weight[2] = 0.0;
  expect_refused(broken, {}, "point 2 of the cloud has weight 0");
}

}  // namespace
}  // namespace impedraw

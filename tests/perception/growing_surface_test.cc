// A surface that frames improve, against the sphere that it is. growing_surface_tsan_test runs the
// same under ThreadSanitizer.
#include "impedraw/perception/growing_surface.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "impedraw/perception/organised_points.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 0.3, kDegrees = 180.0 / std::numbers::pi;
const Vector3d kCentre(0.6, 0.0, 0.4);

double bowl(const Vector3d& o, const Vector3d& d) {
  const Vector3d w = o - kCentre;
  const double b = w.dot(d), q = b * b - w.squaredNorm() + kRadius * kRadius;
  if (q < 0.0) return std::numeric_limits<double>::infinity();
  const double t = -b + std::sqrt(q);
  return (o + t * d).z() < 0.16 ? t : std::numeric_limits<double>::infinity();
}

// Its half with y > 0.
double half_a_bowl(const Vector3d& o, const Vector3d& d) {
  const double t = bowl(o, d);
  return std::isfinite(t) && (o + t * d).y() > 0.0 ? t : std::numeric_limits<double>::infinity();
}

struct Watched {
  std::vector<DepthCamera> cameras = standard_cameras();
  NormalSettings settings;
  PointCloud seen;
  std::unique_ptr<SurfaceEstimator> snapshot;
  SurfaceModel model;
  std::uint64_t seed = 100;
  unsigned looks = 0;

  explicit Watched(const CastRay& cast) {
    settings.k = 90;
    std::vector<DepthImage> images;
    for (DepthCamera& camera : cameras) {
      camera.width = 320;
      camera.height = 240;
      images.push_back(render_depth(camera, cast, realistic_depth_noise(), images.size(), 1));
    }
    snapshot =
        std::make_unique<SurfaceEstimator>(fuse(images, cameras, {.voxel = 0.006}), settings);
    std::vector<SeenPoint> samples;
    const PointCloud& cloud = snapshot->cloud();
    for (std::size_t i = 0; i < cloud.points.size(); ++i)
      if (cloud.normals[i].allFinite())
        samples.push_back({cloud.points[i], cloud.normals[i], 1e-3 / std::sqrt(cloud.weight[i])});
    model.add(samples, {});
  }
  void add_frames(int count, const CastRay& cast) {
    const OrganisedPoints points;
    const Eigen::AlignedBox3d all(Vector3d::Constant(-9.0), Vector3d::Constant(9.0));
    std::vector<SeenPoint> samples;
    for (int k = 0; k < count; ++k)
      for (const DepthCamera& camera : cameras) {
        samples.clear();
        points.find(render_depth(camera, cast, realistic_depth_noise(), ++seed, 1), camera, all, {},
                    0.0, &samples, looks++);
        model.add(samples, {});
      }
  }
};

struct Errors {
  double angle = 0.0, distance = 0.0;  // mean [deg], RMS [mm]
  int missing = 0;
};

template <typename Estimate>
Errors errors(const Estimate& estimate) {
  Errors e;
  int n = 0;
  for (double x = -0.1; x <= 0.1; x += 0.02)
    for (double y = -0.1; y <= 0.1; y += 0.02, ++n) {
      const Vector3d out = Vector3d(x, y, -std::sqrt(kRadius * kRadius - x * x - y * y)) / kRadius;
      const SurfaceEstimate s = estimate(kCentre + (kRadius - 2e-3) * out);
      if (s.status != SurfaceStatus::ok) {
        ++e.missing;
        continue;
      }
      e.angle += kDegrees * std::acos(std::min(1.0, -s.n_W.dot(out)));
      e.distance += 1e6 * std::pow(s.distance - 2e-3, 2);
    }
  e.angle /= n;
  e.distance = std::sqrt(e.distance / n);
  return e;
}

TEST(GrowingSurface, NoiseAveragesAway) {
  Watched w(bowl);
  GrowingSurface surface(*w.snapshot, w.settings, true);
  const auto now = [&](const Vector3d& p) { return surface.estimate(p); };
  const Errors before = errors(now);
  EXPECT_EQ(before.missing, 0);
  w.add_frames(8, bowl);
  surface.offer(w.model.points(), 1.0);
  surface.update(1.0 + GrowingSurface::kBuilding);
  surface.update(3.0);
  const Errors after = errors(now);
  EXPECT_EQ(surface.count(), 1);
  EXPECT_EQ(after.missing, 0);
  EXPECT_LT(after.angle, 0.5 * before.angle) << "after " << before.angle;
  EXPECT_LT(after.distance, 0.6 * before.distance) << "after " << before.distance;
}

// In lock-step it appears at its time, not when the second thread is ready; and it comes in without
// a step.
TEST(GrowingSurface, ComesAtItsTimeAndWithoutAStep) {
  Watched w(bowl);
  GrowingSurface surface(*w.snapshot, w.settings, true);
  const Vector3d p(0.63, 0.02, 0.104);
  const SurfaceEstimate snapshot = w.snapshot->estimate(p);
  w.add_frames(2, bowl);
  surface.offer(w.model.points(), 1.0);
  SurfaceEstimate last = snapshot;
  double most = 0.0, moved = 0.0;
  for (double t = 1.0; t < 2.0; t += 1e-3) {
    surface.update(t);
    const SurfaceEstimate now = surface.estimate(p);
    if (t < 1.0 + GrowingSurface::kBuilding) {
      ASSERT_EQ(now.distance, snapshot.distance) << t;
    }
    most = std::max(most, std::abs(now.distance - last.distance));
    last = now;
  }
  moved = std::abs(last.distance - snapshot.distance);
  EXPECT_GT(moved, 1e-6);
  EXPECT_LT(most, 0.01 * moved) << "1.5 / 300 steps of 1 ms";
}

TEST(GrowingSurface, WhatComesIntoSightIsAddedAndNothingValidIsForgotten) {
  Watched w(half_a_bowl);
  GrowingSurface surface(*w.snapshot, w.settings, true);
  const auto now = [&](const Vector3d& p) { return surface.estimate(p); };
  EXPECT_GT(errors(now).missing, 30);
  // From now on the other half is seen, and the first one no more.
  w.add_frames(4, [](const Vector3d& o, const Vector3d& d) {
    const double t = bowl(o, d);
    return (o + t * d).y() < 0.02 ? t : std::numeric_limits<double>::infinity();
  });
  surface.offer(w.model.points(), 1.0);
  surface.update(3.0);
  surface.update(4.0);
  EXPECT_EQ(errors(now).missing, 0);
}

// Nothing is built that would tell nothing new.
TEST(GrowingSurface, IsBuiltWhereMoreIsKnown) {
  Watched w(bowl);
  GrowingSurface surface(*w.snapshot, w.settings, true);
  double t = 0.0;
  const auto pass = [&](int seconds) {
    for (int i = 0; i < 10 * seconds; ++i, t += 0.1) {
      surface.offer(w.model.points(), t);
      surface.update(t);
    }
  };
  w.add_frames(1, bowl);
  pass(5);
  EXPECT_EQ(surface.count(), 1);
  w.add_frames(1, bowl);
  pass(5);
  EXPECT_EQ(surface.count(), 2);
  pass(5);
  EXPECT_EQ(surface.count(), 2);
}

// On a wall clock nobody waits for it.
TEST(GrowingSurface, OnAWallClockItAppearsWhenItIsReady) {
  Watched w(bowl);
  GrowingSurface surface(*w.snapshot, w.settings, false);
  w.add_frames(1, bowl);
  surface.offer(w.model.points(), 1.0);
  double t = 1.0;
  for (; surface.count() == 0; t += 1e-3) {
    surface.update(t);
    std::this_thread::yield();
  }
  surface.update(t + 1.0);
  const Vector3d p(0.63, 0.02, 0.104);
  EXPECT_EQ(surface.estimate(p).status, SurfaceStatus::ok);
  EXPECT_NE(surface.estimate(p).distance, w.snapshot->estimate(p).distance);
}

}  // namespace
}  // namespace impedraw
